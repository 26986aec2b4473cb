#include "calibrate/rails/rail_model.h"

#include <utility>
#include <vector>

#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {

RailFrame rail_frame(const CaptureSet& set, int line) {
  const CaptureLine& rail = set.lines[static_cast<size_t>(line)];
  RailFrame frame{.axis = rail.axis};
  const double first_m = set.rail_m(rail.frames.front());
  const double last_m = set.rail_m(rail.frames.back());
  frame.rail_middle_m = 0.5 * (first_m + last_m);
  // A line of one station has no length; any value is valid.
  if (last_m > first_m) frame.half_length_m = 0.5 * (last_m - first_m);
  const Eigen::Vector3d axis =
      rail.axis == LineAxis::kX ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int index : rail.frames) {
    const double along_m = set.rail_m(index) - frame.rail_middle_m;
    sum += set.frames[static_cast<size_t>(index)].nominal_m - along_m * axis;
  }
  frame.middle_m = sum / static_cast<double>(rail.frames.size());
  return frame;
}

double station_spacing_m(const CaptureSet& set) {
  std::vector<double> steps_m;
  for (const CaptureLine& line : set.lines) {
    for (std::size_t i = 1; i < line.frames.size(); ++i) {
      steps_m.push_back(set.nominal_distance_m(line.frames[i], line.frames[i - 1]));
    }
  }
  return steps_m.empty() ? 0.025 : covering_spacing(std::move(steps_m));
}

}  // namespace raywalk::calibrate
