// The similarity that takes poses of an unknown frame and scale to a grid's: lines along x and z, y
// up, metres.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/import/imported_poses.h"
#include "core/geometry/grid.h"

namespace raywalk::calibrate {

// x_world = scale * rotation * x_source + translation_m.
struct GridAxes {
  double scale = 1.0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_m{0, 0, 0};
};

CameraPose moved(const GridAxes& axes, const CameraPose& pose);

// A distance between two frames, by their names or files.
struct KnownDistance {
  std::string first{};
  std::string second{};
  double metres = 0.0;
};

// How the scale is known; at most one of them.
struct KnownScale {
  std::optional<double> metres_per_unit{};
  std::optional<double> spacing_m{};  // typical distance of neighbouring stations of a line
  std::optional<double> cell_m{};     // mean side of the cells
  std::optional<KnownDistance> distance{};

  bool any() const { return metres_per_unit || spacing_m || cell_m || distance; }
};

struct AxesOptions {
  bool fit = true;  // else the source's axes are kept, and only the scale is applied
  KnownScale scale{};
  GridTolerance tolerance{};
};

// Up is the normal of the plane through the stations, on the side that the cameras' tops are on; of
// a single line, the cameras' up, square to the line. Where the source's y is up, it stays. About
// it, the lines are turned along x and z: by the least turn, or, if the cameras look in one common
// direction, so that this is nearest to +z. The origin is the middle of the cells, or of the
// stations, at the stations' mean height. Throws Error naming `poses` where the stations form no
// lines, have no common up, or the scale cannot be found; UsageError for a frame of the known
// distance that is not there.
GridAxes fit_grid_axes(const ImportedPoses& poses, const AxesOptions& options);

// The similarity that takes the frames nearest to known positions (indices of frames, and metres),
// by least squares. Throws Error if they are fewer than three or on one line.
struct KnownPosition {
  std::size_t frame = 0;
  Eigen::Vector3d position_m{0, 0, 0};
};
GridAxes fit_known_positions(const ImportedPoses& poses, const std::vector<KnownPosition>& known);

// The stations of frames, for find_grid.
std::vector<StationPose> stations_of(const std::vector<ImportedFrame>& frames,
                                     const GridAxes& axes);

}  // namespace raywalk::calibrate
