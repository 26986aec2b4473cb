#include "core/view/mask_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <tuple>

#include "core/view/test_room.h"

namespace raywalk {
namespace {

// A disc to the right and below, or across the seam, is hidden from all stations but one.
SyntheticRoomSpec room_with_disc(bool masked, int distance_width) {
  SyntheticRoomSpec spec;
  spec.spacing_m = 0.25;
  spec.width = 64;
  spec.distance_width = distance_width;
  spec.companion = CameraCompanion{
      .hides =
          [](const std::string&, int station, const Eigen::Vector3d& direction) {
            const Eigen::Vector3d towards =
                station == 0 ? Eigen::Vector3d(0.1, -0.6, -0.8) : Eigen::Vector3d(0.9, -0.4, 0);
            return station != 2 && direction.dot(towards.normalized()) > 0.9;
          },
      .masked = masked,
      .left_out = !masked};
  return spec;
}

// Whether a pixel of a station may be used, from the room's own runs.
bool pixel_usable(const Room& room, int station, int u, int v) {
  const LineVolume& volume = room.volume(0);
  const RowRun valid = volume.valid_rows(station, u);
  if (v < valid.begin || v >= valid.end) return false;
  const LeftOutPixels& left_out = room.distances(0).left_out();
  if (!left_out.any(station)) return true;
  const PanoramaSize size = volume.panorama(), maps = left_out.size();
  const int row = v * maps.height / size.height;
  return std::ranges::none_of(left_out.rows(station, u * maps.width / size.width),
                              [&](const RowRun& run) { return row >= run.begin && row < run.end; });
}

class MaskCheckTest : public testing::TestWithParam<std::tuple<bool, int, int>> {};

TEST_P(MaskCheckTest, RefusesSamplesThatTouchAPixelThatIsNotToBeUsed) {
  const auto [masked, distance_width, beyond] = GetParam();
  const TestRoom room(room_with_disc(masked, distance_width));
  EXPECT_TRUE(has_masks(room.room(), 0, 0));
  const PanoramaSize size = room.room().panorama();
  std::mt19937 random(9);
  int refused = 0, used = 0;
  for (int station = 0; station < 3; ++station) {
    MaskCheck check(room.room(), 0, station, beyond);
    for (int n = 0; n < 20000; ++n) {
      // Now down a column, now anywhere.
      const int u = n % 50 == 0 ? static_cast<int>(random() % 64) : n / 100 % size.width;
      const auto v = static_cast<int>(random() % static_cast<unsigned>(size.height - 1));
      bool expected = true;
      for (int x = u - beyond; x <= u + 1 + beyond; ++x) {
        for (int y = v - beyond; y <= v + 1 + beyond; ++y) {
          expected &= pixel_usable(room.room(), station, (x + size.width) % size.width,
                                   std::clamp(y, 0, size.height - 1));
        }
      }
      const int left = 3 * (u * size.height + v);
      const int right = 3 * ((u + 1) % size.width * size.height + v);
      ASSERT_EQ(check.usable(left, right), expected) << station << ": " << u << ", " << v;
      ASSERT_TRUE(masked || check.valid(left, right)) << "only masked ones are not";
      (expected ? used : refused) += 1;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(used, 1000);
}

// With masks; and what is left out, in maps of several sizes. Linear and cubic samples.
INSTANTIATE_TEST_SUITE_P(Rooms, MaskCheckTest,
                         testing::Combine(testing::Bool(), testing::Values(64, 24),
                                          testing::Values(0, 1)));

}  // namespace
}  // namespace raywalk
