#include "core/view/column_mixing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kMixingAt{-0.12, 0.2};
constexpr int kMixedRows = 128;
const ViewOptions kTwoSidedMixing{.generation = Generation::kTwoSided, .width = 256};

class MixedColumn {
 public:
  // Beyond the column lies a byte that must be preserved.
  MixedColumn() : rgb(3 * kMixedRows + 1, kUntouched) {}
  void mix(PreparedSteps& prepared, int u, RowRun rows) {
    const auto sources = prepared.sources(u);
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const ColumnShares& shares = prepared.steps.weights.weigh(points, sources);
    prepared.steps.mixing.mix(points, sources, shares, rows, rgb.data());
  }
  // Whether nothing outside of the rows was written.
  bool only_wrote(RowRun rows) const {
    const auto untouched = [](int level) { return level == kUntouched; };
    return std::all_of(rgb.begin(), rgb.begin() + 3 * rows.begin, untouched) &&
           std::all_of(rgb.begin() + 3 * rows.end, rgb.end(), untouched);
  }
  static constexpr std::uint8_t kUntouched = 77;
  std::vector<std::uint8_t> rgb;
};

TEST(ColumnMixing, InRegistersEqualsThroughSums) {
  const TestRoom& room = pillar_room();
  PreparedSteps in_registers(room.room(), kTwoSidedMixing, kMixingAt);
  PreparedSteps through_sums(room.room(), kTwoSidedMixing, kMixingAt,
                             PreparedSteps::Bytes::kCounted);
  for (int u = 0; u < 256; ++u) {
    MixedColumn one;
    MixedColumn other;
    one.mix(in_registers, u, {0, kMixedRows});
    other.mix(through_sums, u, {0, kMixedRows});
    const auto hidden = in_registers.steps.weights
                            .weigh(in_registers.steps.distances.prepare(u), in_registers.sources(u))
                            .hidden;
    for (size_t i = 0; i < 3 * kMixedRows; ++i) {
      if (hidden[i / 6] == kSeen) continue;  // filled later
      ASSERT_LE(std::abs(one.rgb[i] - other.rgb[i]), 1) << u << ", byte " << i;
    }
  }
  const WorkCounts& one = in_registers.steps.mixing.work();
  const WorkCounts& other = through_sums.steps.mixing.work();
  EXPECT_EQ(one.readings, other.readings);
  EXPECT_EQ(in_registers.steps.reader.found(), through_sums.steps.reader.found());
  EXPECT_GT(one.readings, 256 * kMixedRows);
}

TEST(ColumnMixing, PartsOfAColumnEqualTheColumnAndNothingElseIsWritten) {
  const TestRoom& room = pillar_room();
  const auto expect_parts = [](PreparedSteps& prepared) {
    for (int u = 0; u < 256; u += 5) {
      MixedColumn all;
      all.mix(prepared, u, {0, kMixedRows});
      EXPECT_TRUE(all.only_wrote({0, kMixedRows})) << u;
      for (const RowRun rows :
           {RowRun{0, 1}, RowRun{7, 8}, RowRun{3, 90}, RowRun{64, kMixedRows}}) {
        MixedColumn part;
        part.mix(prepared, u, rows);
        ASSERT_TRUE(part.only_wrote(rows)) << u << ", from row " << rows.begin;
        ASSERT_TRUE(std::equal(part.rgb.begin() + 3 * rows.begin, part.rgb.begin() + 3 * rows.end,
                               all.rgb.begin() + 3 * rows.begin))
            << u << ", from row " << rows.begin;
      }
    }
  };
  PreparedSteps in_registers(room.room(), kTwoSidedMixing, kMixingAt);
  expect_parts(in_registers);
  PreparedSteps through_sums(room.room(), kTwoSidedMixing, kMixingAt,
                             PreparedSteps::Bytes::kCounted);
  expect_parts(through_sums);
  PreparedSteps of_one_line(room.room(), {.overlap_deg = 0.0, .width = 256}, kMixingAt);
  expect_parts(of_one_line);
}

TEST(ColumnMixing, ColumnsShowTheRoom) {
  const TestRoom& room = smooth_room();
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    PreparedSteps prepared(room.room(), {.generation = generation, .width = 256}, kMixingAt);
    double difference = 0.0;
    int columns = 0;
    for (int u = 0; u < 256; u += 4, ++columns) {
      MixedColumn column;
      column.mix(prepared, u, {0, kMixedRows});
      for (int row = 0; row < kMixedRows; ++row) {
        const Eigen::Vector3d direction = direction_from_angles(
            angles_from_pixel({double(u), double(row)}, prepared.view.output));
        const Eigen::Vector3d truth =
            color_at(room.spec().scene, prepared.view.viewpoint_m(), direction);
        for (int c = 0; c < 3; ++c) {
          difference += std::fabs(column.rgb[static_cast<size_t>(3 * row + c)] - truth[c]);
        }
      }
    }
    EXPECT_LT(difference / (3.0 * kMixedRows * columns), 1.5) << generation_name(generation);
  }
}

TEST(ColumnMixing, AUniformRoomStaysUniform) {
  SyntheticRoomSpec spec = smooth_spec();
  spec.scene.contrast = 0.0;
  const TestRoom room(spec);
  for (const auto bytes : {PreparedSteps::Bytes::kIgnored, PreparedSteps::Bytes::kCounted}) {
    PreparedSteps prepared(room.room(), kTwoSidedMixing, kMixingAt, bytes);
    for (int u = 0; u < 256; u += 11) {
      MixedColumn column;
      column.mix(prepared, u, {0, kMixedRows});
      for (size_t i = 0; i < 3 * kMixedRows; ++i) ASSERT_NEAR(column.rgb[i], 128, 1) << u;
    }
  }
}

TEST(ColumnMixing, EveryRowOfALineIsReadOnceFromTwoStations) {
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.overlap_deg = 0.0, .width = 256}, kMixingAt);
  MixedColumn().mix(prepared, 30, {0, kMixedRows});
  EXPECT_EQ(prepared.steps.mixing.work().readings, kMixedRows);
  EXPECT_EQ(prepared.steps.mixing.work().uncorrected, 0);
  EXPECT_EQ(prepared.steps.reader.found(), 2 * kMixedRows);
}

}  // namespace
}  // namespace raywalk
