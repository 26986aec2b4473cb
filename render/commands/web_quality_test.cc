#include "render/commands/web_quality.h"

#include <gmock/gmock.h>

#include <iterator>
#include <vector>

#include "core/room/kept_stations.h"
#include "core/view/test_room.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;

ViewOptions options_of(int width) { return {.method = ViewMethod::kTwoSided, .width = width}; }

// Of each line every `stride`-th station.
KeptStations every(int stride, const TestRoom& room) {
  KeptStations kept;
  for (const Line& line : room.room().grid().lines) {
    std::vector<int>& of_line = kept.emplace_back();
    for (int i = 0; i < std::ssize(line.stations); i += stride) of_line.push_back(i);
  }
  return kept;
}

TEST(WebQuality, IsNotMeasuredWhereNothingIsLeftOut) {
  const TestRoom room(box_room(64));
  EXPECT_FALSE(measure_web_quality(room.room(), every(1, room), options_of(64)));
}

TEST(WebQuality, ComparesStationsLeftOutInTheCells) {
  const TestRoom room(box_room(128));
  const KeptStations kept = every(2, room);
  const auto quality = measure_web_quality(room.room(), kept, options_of(128));
  ASSERT_TRUE(quality);
  // Of each line 6 are left out, of which the first and the last lie beyond the cell.
  EXPECT_EQ(quality->views, 16);
  EXPECT_GT(quality->psnr_db, 30.0);
  EXPECT_LE(quality->worst_psnr_db, quality->psnr_db);
  EXPECT_THAT(quality->text, HasSubstr("16 stations that are left out"));
}

TEST(WebQuality, FallsWithTheStations) {
  const TestRoom room(
      {.scene = {.obstacle = SceneBox{{-0.2, -1.2, -0.2}, {0.2, 0.4, 0.2}}}, .overhang_m = 0.25});
  const auto of_stride = [&](int stride) {
    return measure_web_quality(room.room(), every(stride, room), options_of(128))->psnr_db;
  };
  EXPECT_GT(of_stride(2), of_stride(12) + 0.5);
}

TEST(WebQuality, DoesNotCompareWhatIsMasked) {
  const TestRoom plain(box_room(128));
  const TestRoom masked({.overhang_m = 0.25, .companion = masked_below(-0.9)});
  const auto of = [](const TestRoom& room) {
    return measure_web_quality(room.room(), every(2, room), options_of(128))->worst_psnr_db;
  };
  EXPECT_GT(of(masked), of(plain) - 2.0);
}

}  // namespace
}  // namespace raywalk::render
