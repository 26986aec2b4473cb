// Dimensions of the room and the capture grid in it.
//
// The virtual room is built in room units: metres divided by the furniture scale, which defaults to
// the cell's side. A room with another cell side is thus exactly the same room, scaled. Axes are
// those of the world frame (sphere.h); the origin is the middle of the grid at the height of the
// lines, so a station's y is 0.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "simulator/room/room_settings.h"

namespace raywalk::capture {

// An axis-aligned box, room units.
struct RoomBox {
  double x_min = 0.0, x_max = 0.0;
  double y_min = 0.0, y_max = 0.0;
  double z_min = 0.0, z_max = 0.0;
};

// One run of the slider, room units.
struct PlannedLine {
  std::string id;  // as Line::id of core/geometry/grid.h
  LineAxis axis = LineAxis::kX;
  double across = 0.0;        // z of a line along x, x of a line along z
  std::vector<double> along;  // positions of its stations, increasing

  // In world axes.
  Eigen::Vector3d position(double at_along) const {
    return axis == LineAxis::kX ? Eigen::Vector3d(at_along, 0.0, across)
                                : Eigen::Vector3d(across, 0.0, at_along);
  }
};

struct RoomPlan {
  int seed = 0;
  double unit_m = 1.0;  // metres per room unit
  RoomBox walls{};
  double cell_side = 1.0;
  int cells_x = 1, cells_z = 1;
  std::vector<PlannedLine> lines;  // along x in order of z, then along z in order of x
  double clearance = 0.25;         // free horizontal distance around the lines
  double headroom = 0.25;          // free vertical distance above and below them

  // The cells that true views are in, in the order in which they are taken; cell = row (along z) *
  // cells_x + column (along x).
  std::vector<int> truth_cells;

  // (x, z) of the middle of a cell, in units of a cell's side.
  Eigen::Vector2d cell_centre(int column, int row) const {
    return {column + 0.5 - 0.5 * cells_x, row + 0.5 - 0.5 * cells_z};
  }
  double grid_half_x() const { return 0.5 * cells_x * cell_side; }
  double grid_half_z() const { return 0.5 * cells_z * cell_side; }
  double overhang = 0.0;  // captured beyond the outer corners
};

// Throws UsageError naming the key if the room is too small for the grid, a line would have more
// than 10,000 stations, the camera would not be between floor and ceiling, or the furniture scale
// is neither 0 nor at least kLeastFurnitureScale_m.
RoomPlan plan_room(const VirtualRoomSettings& settings);

}  // namespace raywalk::capture
