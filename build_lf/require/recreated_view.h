// Re-creates a station's panorama from its two neighbours on the line, to measure the loss from
// leaving it out.
#pragma once

#include <Eigen/Core>

#include "build_lf/require/omega_map.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A station's rays, its position, and the inverse distances seen from it.
struct StationView {
  const LineVolume* rays = nullptr;
  int station = 0;
  Eigen::Vector3d position_m{0, 0, 0};
  const OmegaMap* omega = nullptr;
};

struct RecreationScore {
  double psnr_with_distances_db = 0.0;  // over RGB, at most 100
  double psnr_without_depth_db = 0.0;
  double psnr_of_tolerance_db = 0.0;  // captured view against itself, displaced by the tolerance
  double hidden_share = 0.0;          // of the solid angle: seen by neither neighbour
};

// Re-creates the view of `truth` from `left` and `right` and compares it with the captured one, on
// a grid of pixels about `width` wide.
// - With distances: each ray's point, by truth.omega, is projected into both stations and the two
//   colours are blended by nearness. A station in which the point is occluded (by its own omega) or
//   masked is left out, unless both occlude it. Pixels masked in `truth` or in both stations are
//   not compared.
// - Without depth: the same pixel of both stations is blended (the vertical cut).
// The PSNR of the tolerance is that of the captured view against itself, displaced by
// `tolerance_px` of its pixels once along rows and once along columns. It depends on the scene's
// texture.
RecreationScore score_recreation(const StationView& truth, const StationView& left,
                                 const StationView& right, double tolerance_px, int width);

// 10 log10(255^2 / mean squared error), at most 100 dB.
double psnr_db(double mean_squared_error);

}  // namespace raywalk::build_lf
