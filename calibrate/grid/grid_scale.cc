#include "calibrate/grid/grid_scale.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {

GridScale grid_scale(const CaptureSet& set) {
  std::vector<double> spacings, lengths;
  for (const CaptureLine& line : set.lines) {
    for (size_t i = 1; i < line.frames.size(); ++i) {
      spacings.push_back(set.rail_m(line.frames[i]) - set.rail_m(line.frames[i - 1]));
    }
    const double length_m = set.rail_m(line.frames.back()) - set.rail_m(line.frames.front());
    if (length_m > 0.0) lengths.push_back(length_m);
  }
  GridScale scale{.pixel_rad = kTwoPi / std::max(1, set.frame.width)};
  if (!spacings.empty()) scale.spacing_m = covering_spacing(std::move(spacings));
  if (!lengths.empty()) scale.length_m = median(std::move(lengths));
  return scale;
}

CrossingFitScale fit_scale(const GridScale& scale) {
  return {.scene_m = scale.length_m,
          .motion_m = std::max(2.0 * scale.spacing_m, 0.1 * scale.length_m),
          .pixel_rad = scale.pixel_rad};
}

}  // namespace raywalk::calibrate
