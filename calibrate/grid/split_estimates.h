// The difference of two estimates at a crossing, each from half of the data.
#pragma once

#include <span>
#include <vector>

#include "calibrate/grid/crossing_figures.h"
#include "calibrate/grid/rail_fit.h"

namespace raywalk::calibrate {

// A line's two fits, each from every other sample.
struct HalfFits {
  RailFrame frame{};
  bool enough = false;  // there are enough samples for two fits
  std::array<RailFit, 2> fits{};
  std::array<std::vector<double>, 2> samples_u{};
  double position_scatter_m = 0.0;  // of one sample, per component
  double rotation_scatter_rad = 0.0;
};
HalfFits fit_halves(const RailFrame& frame, std::span<const RailSample> samples, double spacing_m);

// The difference of the relative pose of two rails where they cross; zeros where either has too few
// samples.
SplitDifference split_by_stations(const HalfFits& x, const HalfFits& z, PlanPoint at);

// The same between the halves of a crossing's matches, at the given poses.
SplitDifference split_by_matches(const CrossingMatches& crossing, const FramePoses& poses,
                                 const CrossingFitScale& scale);

}  // namespace raywalk::calibrate
