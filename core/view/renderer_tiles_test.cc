// Views of rooms whose rays are compressed.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/room/tiled_rays.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr PlanPoint kPlaces[] = {{0.1, -0.05}, {-0.3, 0.35}};

// A limit of the cache for the length of a test.
class CacheLimit {
 public:
  explicit CacheLimit(std::uint64_t bytes) { TileCache::of_process().set_limit_bytes(bytes); }
  ~CacheLimit() { TileCache::of_process().set_limit_bytes(TileCache::default_limit_bytes()); }
};

SyntheticRoomSpec spec_of(RayForm::Kind kind, bool masked) {
  SyntheticRoomSpec spec = box_room(96);
  spec.form = {kind, 0};
  spec.distance_width = spec.width / 2;
  if (masked) {
    spec.companion.emplace().hides = [](const std::string&, int, const Eigen::Vector3d& d) {
      return d.y() < -0.8;
    };
  }
  return spec;
}

std::vector<ViewOptions> all_options(int width) {
  std::vector<ViewOptions> all;
  for (const ViewMethod method : kViewMethods) {
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
      all.push_back({.method = method, .width = width, .interpolation = interpolation});
    }
  }
  all.push_back({.method = ViewMethod::kTwoSided, .width = 4 * width / 3});
  all.push_back({.method = ViewMethod::kHlfVd, .width = width, .stations_mixed = 8});
  return all;
}

class TiledViewsTest : public testing::TestWithParam<bool> {};

TEST_P(TiledViewsTest, ShowLosslessRaysAsTheRawOnes) {
  const TestRoom raw(spec_of(RayForm::Kind::kRaw, GetParam()));
  const TestRoom tiled(spec_of(RayForm::Kind::kLossless, GetParam()));
  for (const std::uint64_t limit : {std::uint64_t{1} << 32, std::uint64_t{1}}) {
    const CacheLimit limited(limit);
    const TileCounts before = TileCache::of_process().counts();
    for (const ViewOptions& options : all_options(raw.spec().width)) {
      for (const PlanPoint place : kPlaces) {
        EXPECT_EQ(largest_difference(tiled.image(options, place), raw.image(options, place)), 0.0)
            << limit << ' ' << method_name(options.method);
      }
    }
    const TileCounts after = TileCache::of_process().counts();
    if (limit == 1) {
      EXPECT_GT(after.evicted, before.evicted + 1000);
      EXPECT_LE(after.bytes, limit);
    } else {
      EXPECT_GT(after.decoded, before.decoded);
      EXPECT_EQ(after.evicted, before.evicted);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Masked, TiledViewsTest, testing::Bool());

}  // namespace
}  // namespace raywalk
