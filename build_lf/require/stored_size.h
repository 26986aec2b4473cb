// The resolution and precision needed for a room's panoramas and distances.
#pragma once

#include "build_lf/require/facts.h"
#include "core/geometry/spacing.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The conditions that the sizes have to satisfy.
struct StorageNeed {
  double reach_m = 0.0;       // from viewpoint to line
  double spacing_m = 0.0;     // of the stations in use
  double tolerance_px = 0.5;  // at the panorama's width
  double omega_error = 0.0;   // 1/m, of the distances
  OmegaRange scene{};         // inverse distances
};

// The panorama width, pixels, at which the residual parallax equals `tolerance_px` of its own
// pixels; infinity if there is none. An error e of an inverse distance leaves up to reach * e in
// latitude (the slope of (5), see layer_count.h) and, at right angles, spacing / 2 * e along the
// rail (half the ghost, see spacing.h). A wider panorama would store detail that views displace by
// more than the tolerance.
double useful_width(const StorageNeed& need);

// Higher than kTrustedShare (scene_facts.h), because coarse maps lose silhouettes, where views
// tear. In white-room, maps that kept 97.6 % and 99.1 % cost hlf-vd views 3.2 dB and 1.4 dB,
// two-sided views 1.2 dB and 0.4 dB. The loss is proportional to the wrong share, so 0.2 % cost
// about 0.3 dB.
inline constexpr double kKeptShare = 0.998;

struct DistanceWidth {
  int width_px = 0;
  double share_within_tolerance = 1.0;  // of the solid angle
};

// The smallest width, halving from that of the maps, at which (as at all larger ones) the
// displacement reach * |error of omega| is within the tolerance for kKeptShare of the solid angle
// of a sample of maps. Coarse maps are interpolated as in distance_maps.h.
DistanceWidth distance_width_needed(const Room& room, const StorageNeed& need);

// Widths, precision and bytes; `stations_needed` is the number of stations to keep.
StorageFacts storage_facts(const Room& room, const StorageNeed& need, int stations_needed);

}  // namespace raywalk::build_lf
