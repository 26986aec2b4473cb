// How wide and how precise a room's pictures and distances have to be stored.
#pragma once

#include "core/geometry/layer_count.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// What the sizes are chosen for.
struct StorageNeed {
  double reach_m = 0.0;       // from viewpoint to line
  double spacing_m = 0.0;     // of the stations in use
  double tolerance_px = 0.5;  // at the panorama's width
  double omega_error = 0.0;   // 1/m, of the distances
  OmegaRange scene{};         // inverse distances
};

// The panorama width at which the parallax that is left equals `tolerance_px` of its own pixels;
// infinity without any. What is left of a distance whose inverse is wrong by e: up to reach * e in
// latitude (the slope of (5), see layer_count.h) and spacing / 2 * e along the rail (half of the
// ghost, see spacing.h), at right angles. A wider panorama would store detail that a view displaces
// by more than the tolerance.
double width_worth_storing(const StorageNeed& need);

// More than kTrustedShare of distance_error.h: what a coarse map loses is silhouettes, where views
// tear. In white-room maps that kept 97.6 and 99.1 % cost hlf-vd views 3.2 and 1.4 dB, two-sided
// ones 1.2 and 0.4: in proportion to what is wrong, so that 0.2 % cost about 0.3 dB.
inline constexpr double kKeptShare = 0.998;

struct DistanceWidth {
  int width_px = 0;
  double share_within_tolerance = 1.0;  // of the solid angle
};

// The coarsest of the maps' own width and its halves at which, as at all finer ones, kKeptShare
// of the solid angle of some maps keep a distance that displaces a pixel by no more than the
// tolerance: reach * |error of omega|. Coarse maps are read as omega_map.h interpolates them.
DistanceWidth distance_width_needed(const Room& room, const StorageNeed& need);

// Widths, precision and bytes; `stations_needed` of them kept.
StorageFacts storage_facts(const Room& room, const StorageNeed& need, int stations_needed);

}  // namespace raywalk::build_lf
