#include "core/view/row_readings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/view/test_points.h"
#include "core/view/test_room.h"
#include "core/view/test_steps.h"

namespace raywalk {
namespace {

constexpr PlanPoint kReadingsAt{-0.07, 0.31};
constexpr PanoramaSize kReadingsSize{256, 128};
constexpr RowRun kAllReadingRows{0, 128};

// How each output row is read; kNothing where no piece covers it. Fails where pieces overlap.
std::vector<Reading> readings_of(std::span<const RowPiece> pieces) {
  std::vector<Reading> readings(128, Reading::kNothing);
  int end = 0;
  for (const RowPiece& piece : pieces) {
    EXPECT_FALSE(piece.rows.empty());
    EXPECT_GE(piece.rows.begin, end) << "pieces overlap";
    end = piece.rows.end;
    for (int row = piece.rows.begin; row < end; ++row) {
      readings[static_cast<size_t>(row)] = piece.reading;
    }
  }
  EXPECT_LE(end, 128);
  return readings;
}

// Where a station saw what a pixel of the view shows.
PixelPosition seen_by(const PreparedSteps& prepared, const SyntheticScene& scene, int u, int row,
                      const Eigen::Vector3d& station) {
  const Eigen::Vector3d point =
      point_at(scene, prepared.view.viewpoint_m(), {double(u), double(row)}, kReadingsSize);
  return pixel_from_angles(angles_from_direction(point - station), kReadingsSize);
}

// The larger of the differences in columns and in rows.
double apart_px(PixelPosition a, PixelPosition b) {
  return std::max(std::fabs(std::remainder(a.u - b.u, kReadingsSize.width)), std::fabs(a.v - b.v));
}

TEST(RowReadings, NothingIsSkippedAtZero) {
  const TestRoom& room = pillar_room();
  for (const int stations_mixed : {1, 2}) {
    PreparedSteps prepared(room.room(), {.width = 256, .stations_mixed = stations_mixed},
                           kReadingsAt);
    const ColumnPoints& points = prepared.steps.distances.prepare(20);
    const RaySource source = prepared.sources(20).front();
    const std::vector<std::uint8_t> needed(64, 0);  // rows are read whether needed or not
    const auto pieces = prepared.steps.readings.split(points, source, {5, 111}, needed, 0.0);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_EQ(pieces[0].rows, (RowRun{5, 111}));
    EXPECT_EQ(pieces[0].reading, stations_mixed == 2 ? Reading::kBoth : nearer_station(source));
  }
}

TEST(RowReadings, CoverTheNeededRowsExactly) {
  const TestRoom& room = pillar_room();
  for (const int layers : {0, 8}) {  // with layers every row has a reading of its own
    for (const double skip_px : {0.0, 1.5}) {
      PreparedSteps prepared(room.room(),
                             {.generation = Generation::kTwoSided,
                              .layers = layers,
                              .width = 256,
                              .second_side = SecondSide::kWhereHidden,
                              .skip_px = skip_px},
                             kReadingsAt);
      for (int u = 0; u < 256; u += 3) {
        const ColumnPoints& points = prepared.steps.distances.prepare(u);
        std::vector<std::uint8_t> needed(64);
        for (size_t row = 0; row < needed.size(); ++row) needed[row] = (u + row) % 7 < 4 ? 255 : 0;
        const RowRun rows{9, 120};
        const auto readings = readings_of(prepared.steps.readings.split(
            points, prepared.sources(u).front(), rows, needed, skip_px));
        for (int row = 0; row < 128; ++row) {
          const auto i = static_cast<size_t>(row);
          const bool wanted = row >= rows.begin && row < rows.end && needed[i / 2] != 0;
          ASSERT_EQ(readings[i] != Reading::kNothing, wanted) << u << ", " << row;
        }
      }
    }
  }
}

TEST(RowReadings, RowsAreReadUncorrectedOnlyWhereBothStationsSawThemNearby) {
  constexpr double kSkip_px = 4.0;
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.width = 256, .skip_px = kSkip_px}, {0.02, 0.48});
  const std::vector<std::uint8_t> needed(64, 255);
  int stored = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    for (const RaySource& source : prepared.sources(u)) {
      const auto readings = readings_of(
          prepared.steps.readings.split(points, source, kAllReadingRows, needed, kSkip_px));
      for (int row = 0; row < 128; ++row) {
        if (readings[static_cast<size_t>(row)] != Reading::kStored) continue;
        ++stored;
        for (int next = 0; next < 2; ++next) {
          const PixelPosition at =
              seen_by(prepared, room.spec().scene, u, row,
                      station_position(prepared.view, source.line, source.station + next));
          ASSERT_LE(apart_px(at, {double(u), double(row)}), kSkip_px + 0.1) << u << ", " << row;
        }
      }
    }
  }
  EXPECT_GT(stored, 1000);
}

TEST(RowReadings, TheFartherStationIsSkippedOnlyWhereItMovesAPixelLittle) {
  constexpr double kSkip_px = 0.5;
  const TestRoom& room = smooth_room();
  PreparedSteps prepared(room.room(), {.width = 256, .skip_px = kSkip_px}, kReadingsAt);
  const std::vector<std::uint8_t> needed(64, 255);
  int one = 0;
  int both = 0;
  for (int u = 0; u < 256; ++u) {
    const ColumnPoints& points = prepared.steps.distances.prepare(u);
    const RaySource source = prepared.sources(u).front();
    const double share = std::min(source.fraction, 1.0 - source.fraction);
    const auto readings = readings_of(
        prepared.steps.readings.split(points, source, kAllReadingRows, needed, kSkip_px));
    for (int row = 0; row < 128; ++row) {
      const Reading reading = readings[static_cast<size_t>(row)];
      if (reading == Reading::kBoth) ++both;
      if (reading == Reading::kBoth || reading == Reading::kStored) continue;
      ASSERT_EQ(reading, nearer_station(source)) << u << ", " << row;
      ++one;
      const auto at = [&](int next) {
        return seen_by(prepared, room.spec().scene, u, row,
                       station_position(prepared.view, source.line, source.station + next));
      };
      ASSERT_LE(share * apart_px(at(0), at(1)), 1.05 * kSkip_px) << u << ", " << row;
    }
  }
  EXPECT_GT(one, 500);
  EXPECT_GT(both, 500);
}

}  // namespace
}  // namespace raywalk
