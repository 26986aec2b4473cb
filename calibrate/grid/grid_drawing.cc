#include "calibrate/grid/grid_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/report/plan_drawing.h"

namespace raywalk::calibrate {
namespace {

PlanPoint in_plan(const Eigen::Vector3d& position) { return {position.x(), position.z()}; }

// The largest of 1, 2, 5, 10, 20, ... that leaves the largest motion within a tenth of the plan.
double exaggeration(double largest_m, double extent_m) {
  if (!(largest_m > 0.0)) return 1.0;
  const double room = 0.1 * extent_m / largest_m;
  if (room <= 1.0) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(std::min(room, 1e6))));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= room) return step * power;
  }
  return power;
}

}  // namespace

std::string grid_drawing(const CaptureSet& set, const GridResult& result) {
  PlanBounds bounds;
  double largest_m = 0.0;
  for (size_t i = 0; i < set.frames.size(); ++i) {
    const Eigen::Vector3d& planned = set.frames[i].nominal_m;
    bounds.add(in_plan(planned));
    const Eigen::Vector3d moved = result.poses[i]->position_m - planned;
    largest_m = std::max(largest_m, std::hypot(moved.x(), moved.z()));
  }
  // A drawing needs an extent both of one station and of one line.
  const double extent_m = std::max({bounds.width_m(), bounds.depth_m(), 1e-6});
  const double times = exaggeration(largest_m, extent_m);
  const double margin_m = 0.12 * extent_m;
  bounds.add({bounds.min.x_m - margin_m, bounds.min.z_m - margin_m});
  bounds.add({bounds.max.x_m + margin_m, bounds.max.z_m + margin_m});

  PlanDrawing drawing(bounds, 24.0);
  for (const CaptureLine& line : set.lines) {
    const Eigen::Vector3d& first = set.frames[static_cast<size_t>(line.frames.front())].nominal_m;
    const Eigen::Vector3d& last = set.frames[static_cast<size_t>(line.frames.back())].nominal_m;
    if (line.frames.size() > 1) drawing.add_line("planned", in_plan(first), in_plan(last));
    drawing.add_label(line.id, in_plan(last),
                      line.axis == LineAxis::kX ? LabelSide::kRight : LabelSide::kAbove);
  }
  for (size_t i = 0; i < set.frames.size(); ++i) {
    const Eigen::Vector3d& planned = set.frames[i].nominal_m;
    const FramePose& pose = *result.poses[i];
    const Eigen::Vector3d shown = planned + times * (pose.position_m - planned);
    drawing.add_line("moved", in_plan(planned), in_plan(shown));
    drawing.add_dot(pose.origin == PoseOrigin::kSolved ? "solved" : "predicted", in_plan(shown),
                    2.0);
  }
  const std::vector<std::string> notes{
      fmt::format("Motions are drawn {} times as large; the largest is {:.1f} mm.", times,
                  1e3 * largest_m),
      "Full dots: stations with a solved pose; open dots: stations predicted from the rail."};
  return drawing.svg("Lines as planned and as estimated",
                     ".raywalk-plan .planned{stroke:var(--soft);stroke-width:1.5}"
                     ".raywalk-plan .moved{stroke:var(--soft);stroke-width:.5}"
                     ".raywalk-plan .solved{fill:var(--accent)}"
                     ".raywalk-plan .predicted{fill:none;stroke:var(--accent)}",
                     notes);
}

}  // namespace raywalk::calibrate
