// poses.csv and gt.csv of a calibrated capture.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

// A row of a frame list.
struct ListedFrame {
  std::string file{};  // relative to the list, or absolute
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<Attitude> attitude{};  // nullopt: the picture is in world axes
  std::string mask{};                  // as file; empty: none
};

// The table file,x,y,z (metres), with columns yaw,pitch,roll (degrees) where a frame has an
// attitude and a column mask where one has a mask.
std::string frame_list_text(const std::vector<ListedFrame>& frames);

// The --line-tolerance-mm with which raywalk-build-lf pack finds these frames on `lines` lines; 0:
// its default is sufficient. nullopt if none is, neither that with which the capture's lines were
// found (`given`) nor one up to half the stations' spacing. Its --same-station-mm is that of
// `given`.
std::optional<double> line_tolerance_needed_mm(const std::vector<ListedFrame>& frames, int lines,
                                               const GridTolerance& given = {});

}  // namespace raywalk::calibrate
