#include "build_lf/depth/map_images.h"

#include <gtest/gtest.h>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

TEST(MapImagesTest, AreThreeOfEachMapEvenOfSky) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.width = 32;
  const DepthTestRoom room{spec};
  std::vector<InverseDistanceMap> maps(2, true_map(spec.scene, {0, 0, -0.5}, {32, 16}));
  for (float& omega : maps[1].omega) omega = 0.0f;
  for (std::uint8_t& confidence : maps[1].confidence) confidence = 0;
  const std::vector<ReportImage> images = map_images(room.room(), maps);
  ASSERT_EQ(images.size(), 6U);
  EXPECT_EQ(images[0].row, "line x0, station 0");
  EXPECT_EQ(images[1].caption, "inverse distance");
  EXPECT_TRUE(images[5].source.starts_with("data:image/jpeg"));
}

}  // namespace
}  // namespace raywalk::build_lf
