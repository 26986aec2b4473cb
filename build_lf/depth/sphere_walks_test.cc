#include "build_lf/depth/sphere_walks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {
namespace {

TEST(SphereWalksTest, CrossEveryPixelOncePerDirection) {
  for (const PanoramaSize size : {PanoramaSize{8, 4}, {32, 16}, {36, 18}, {128, 64}}) {
    std::vector<std::atomic<int>> visits(static_cast<std::size_t>(size.width * size.height));
    for_each_walk(size, [&](Walk walk, int run_up, int steps) {
      for (int i = -run_up; i < steps; ++i) {
        const std::size_t pixel = pixel_index(walk.theta, walk.phi, size);
        ASSERT_LT(pixel, visits.size());
        if (i >= 0) ++visits[pixel];
        walk.advance(size);
      }
    });
    for (const auto& count : visits) EXPECT_EQ(count, kPaths) << size.width;
  }
}

}  // namespace
}  // namespace raywalk::build_lf
