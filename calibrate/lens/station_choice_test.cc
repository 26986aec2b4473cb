#include "calibrate/lens/station_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace raywalk::calibrate {
namespace {

// `lines` of each axis, `stations` each, 5 cm apart, crossing at their middles' outskirts.
CaptureSet grid_of(int along_x, int along_z, int stations) {
  CaptureSet set;
  for (int line = 0; line < along_x + along_z; ++line) {
    const bool is_x = line < along_x;
    CaptureLine made;
    made.id = std::to_string(line);
    made.axis = is_x ? LineAxis::kX : LineAxis::kZ;
    made.across_m = 0.5 * (is_x ? line : line - along_x);
    for (int i = 0; i < stations; ++i) {
      made.frames.push_back(static_cast<int>(set.frames.size()));
      CaptureFrame frame;
      frame.line = line;
      const double along_m = 0.05 * i;
      frame.nominal_m = is_x ? Eigen::Vector3d(along_m, 0, made.across_m)
                             : Eigen::Vector3d(made.across_m, 0, along_m);
      set.frames.push_back(frame);
    }
    set.lines.push_back(made);
  }
  return set;
}

TEST(StationChoiceTest, EveryLineHasItsEndsAndMiddle) {
  const CaptureSet set = grid_of(2, 2, 31);
  const std::vector<std::size_t> chosen = choose_stations(set, 24);
  EXPECT_THAT(chosen, ::testing::SizeIs(24));
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  for (int line = 0; line < 4; ++line) {
    EXPECT_THAT(chosen, ::testing::Contains(31 * line));
    EXPECT_THAT(chosen, ::testing::Contains(31 * line + 15 - 3));
    EXPECT_THAT(chosen, ::testing::Contains(31 * line + 30));
  }
}

TEST(StationChoiceTest, FewStationsAreOnFewLinesButOfBothAxes) {
  for (const auto& [along_x, along_z] : {std::pair(3, 2), {1, 6}, {6, 1}, {20, 20}}) {
    const CaptureSet set = grid_of(along_x, along_z, 9);
    std::set<LineAxis> axes;
    std::set<int> lines;
    for (const std::size_t frame : choose_stations(set, 10)) {
      lines.insert(set.frames[frame].line);
      axes.insert(set.lines[static_cast<std::size_t>(*lines.rbegin())].axis);
    }
    EXPECT_EQ(lines.size(), 2U);
    EXPECT_EQ(axes.size(), 2U);
  }
}

TEST(StationChoiceTest, ShortCapturesAreUsedWhole) {
  EXPECT_THAT(choose_stations(grid_of(1, 0, 4), 24), ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(choose_stations(grid_of(1, 1, 2), 24), ::testing::SizeIs(4));
  EXPECT_THAT(choose_stations(CaptureSet{}, 24), ::testing::IsEmpty());
}

TEST(StationChoiceTest, NeighboursAndCrossingLinesAreCompared) {
  const CaptureSet set = grid_of(1, 1, 11);
  const std::vector<std::size_t> chosen =
      choose_stations(set, 12);  // 10 cm apart, both from the origin
  const std::vector<StationPair> pairs = pairs_to_match(set, chosen);
  int on_line = 0, across = 0;
  for (const StationPair& pair : pairs) {
    ASSERT_LT(pair.first, pair.second);
    ((pair.first < 6) == (pair.second < 6) ? on_line : across) += 1;
  }
  EXPECT_EQ(on_line, 2 * (5 + 4));
  EXPECT_GE(across, 3);  // the corner, and each line's first against the other's second
  EXPECT_LE(across, 4);
}

}  // namespace
}  // namespace raywalk::calibrate
