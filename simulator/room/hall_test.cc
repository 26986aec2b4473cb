#include "simulator/room/hall.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <set>

#include "core/geometry/grid.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

VirtualRoomSettings hall_of(int cells_x, int cells_z, double spacing_mm) {
  VirtualRoomSettings settings;
  settings.place = "hall";
  settings.grid = {.cell_side_m = 0.5,
                   .cells_x = cells_x,
                   .cells_z = cells_z,
                   .spacing_mm = spacing_mm,
                   .overhang_share = 0.0,
                   .shared_crossings = true};
  settings.room.furniture_scale_m = 1.0;
  return settings;
}

// Where a ray meets the triangle (Moeller and Trumbore 1997), infinity if it does not.
double distance_to(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& from,
                   const Vector3d& direction) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Vector3d ab = b - a, ac = c - a, p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (std::fabs(determinant) < 1e-14) return kNone;
  const Vector3d s = from - a, q = s.cross(ab);
  const double u = s.dot(p) / determinant, v = direction.dot(q) / determinant;
  const double distance = ac.dot(q) / determinant;
  const bool meets = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-9;
  return meets ? distance : kNone;
}

// Without the ray tracer: the nearest of all facets.
double distance_along(const Facets& facets, const Vector3d& from, const Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Facet& facet : facets.facets) {
    const auto& at = facet.corners;
    nearest = std::min({nearest, distance_to(at[0], at[1], at[2], from, direction),
                        distance_to(at[0], at[2], at[3], from, direction)});
  }
  return nearest;
}

TEST(HallTest, DistancesAreThoseToItsFacets) {
  const VirtualRoomSettings settings = hall_of(2, 2, 125.0);
  const VirtualRoom hall(settings);
  const FurnishedRoom built = build_hall(hall.plan(), settings);
  constexpr PanoramaSize kSize{32, 16};
  const Vector3d at(-0.25, 0.0, 0.25);
  const cv::Mat map = hall.distance_map({at, {}}, kSize);
  int differ = 0;
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const Vector3d direction = direction_from_angles(
          angles_from_pixel({static_cast<double>(u), static_cast<double>(v)}, kSize));
      const double expected = distance_along(built.facets, at, direction);
      if (std::fabs(static_cast<double>(map.at<float>(v, u)) - expected) > 1e-4) ++differ;
    }
  }
  // A ray along an edge may pass it on either side.
  EXPECT_LE(differ, 2);
}

TEST(HallTest, StandsAreInTheMiddleOfTheCellsOfTheirRow) {
  const VirtualRoomSettings settings = hall_of(4, 6, 125.0);
  const RoomPlan plan = plan_hall(settings);
  const FurnishedRoom built = build_hall(plan, settings);
  int stands = 0;
  for (int row = 0; row < plan.cells_z; ++row) {
    for (int column = 0; column < plan.cells_x; ++column) {
      const Vector2d centre = plan.cell_side * plan.cell_centre(column, row);
      const Vector3d from(centre.x() - 0.5 * plan.cell_side, 0.0, centre.y());
      const bool stands_here =
          distance_along(built.facets, from, Vector3d::UnitX()) < 0.5 * plan.cell_side;
      EXPECT_EQ(stands_here, has_stand(settings.hall, column, row)) << column << "," << row;
      stands += stands_here ? 1 : 0;
    }
  }
  EXPECT_EQ(stands, 5);  // one row of six cells, with a gap in the last
}

// The hall of configs/virtual-hall.yaml: 57 lines of 301 stations and 7 of 2801 that leave the 57
// crossings to them.
TEST(HallTest, LargeGridsShareTheirCrossings) {
  const RoomPlan plan = plan_hall(hall_of(6, 56, 10.0));
  std::size_t stations = 0;
  for (const PlannedLine& line : plan.lines) stations += line.along.size();
  EXPECT_EQ(plan.lines.size(), 64U);
  EXPECT_EQ(stations, 57U * 301U + 7U * (2801U - 57U));
  std::set<int> cells(plan.truth_cells.begin(), plan.truth_cells.end());
  EXPECT_EQ(cells.size(), plan.truth_cells.size());
  EXPECT_EQ(cells.size(), 336U - 2U * 47U);  // two rows of stands, with nine gaps each
  // A few of them are all over the hall.
  std::set<int> parts;
  for (int i = 0; i < 8; ++i) parts.insert(plan.truth_cells[static_cast<std::size_t>(i)] / 6 / 14);
  EXPECT_EQ(parts.size(), 4U);
}

TEST(HallTest, CellsCloseWhereLinesShareTheirCrossings) {
  const RoomPlan plan = plan_hall(hall_of(3, 4, 100.0));
  std::vector<StationPose> stations;
  for (const PlannedLine& line : plan.lines) {
    for (const double along : line.along) {
      stations.push_back({line.id, plan.unit_m * line.position(along), ""});
    }
  }
  const Grid grid = find_grid(stations, {});
  EXPECT_EQ(grid.lines.size(), plan.lines.size());
  EXPECT_EQ(grid.cells.size(), 12U);
}

}  // namespace
}  // namespace raywalk::capture
