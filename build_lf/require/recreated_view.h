// A station's panorama made again from its two neighbours on the line, to see what leaving it out
// costs.
#pragma once

#include <Eigen/Core>

#include "build_lf/require/omega_map.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A station's rays, its place, and the inverse distances it sees.
struct StationView {
  const LineVolume* rays = nullptr;
  int station = 0;
  Eigen::Vector3d position_m{0, 0, 0};
  const OmegaMap* omega = nullptr;
};

struct RecreationScore {
  double psnr_with_distances_db = 0.0;  // over RGB, at most 100
  double psnr_without_depth_db = 0.0;
  double psnr_of_tolerance_db = 0.0;  // of the captured view, displaced by the tolerance
  double hidden_share = 0.0;          // of the solid angle: seen by neither neighbour
};

// Makes the view of `truth` from `left` and `right` and compares it with what was captured, over
// the pixels of a grid about `width` wide.
// - With distances each ray's point, by truth.omega, is looked up where the two stations saw it
//   and blended by nearness; a station from which, by its own omega, something nearer hides the
//   point is left out unless both are.
//   What is masked in a station is not seen from it; pixels masked in `truth` or in both others are
//   not compared.
// - Without depth the same pixel of both stations is blended: the vertical cut.
// What the tolerance stands for in this view is told by the view itself, each pixel displaced by
// `tolerance_px` of its own once along its row and once along its column: fine texture makes much
// of it, a blank wall nothing.
RecreationScore score_recreation(const StationView& truth, const StationView& left,
                                 const StationView& right, double tolerance_px, int width);

// 10 log10(255^2 / mean squared error), at most 100 dB.
double psnr_db(double mean_squared_error);

}  // namespace raywalk::build_lf
