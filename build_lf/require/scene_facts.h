// Facts about a room's scene, from its distances: their range and error, and the resolution and
// precision that its panoramas and distances need.
#pragma once

#include <optional>

#include "build_lf/require/facts.h"
#include "core/geometry/spacing.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// The range of distances, and their reliability. Throws Error if the
// room has no known distance.
DistanceFacts distance_facts(const Room& room);

// The typical d_p, metres, for which layers and storage are computed: half the shorter side of the
// smallest cell; without cells, half the side of the cell that the longest line could close.
double typical_reach_m(const Grid& grid);

// The layers needed for `tolerance_rad` at d_p from a tenth of `reach_m` up to the diagonal of a
// cell.
LayerFacts layer_facts(const DistanceFacts& distance, double reach_m, double tolerance_rad);

// The quantile at which errors are stated; the remaining pixels are outliers (silhouettes,
// reflections, thin objects).
inline constexpr double kTrustedShare = 0.95;

// The error of an inverse distance, 1/m. Each map of a sample is compared with the map captured
// nearest to it: over the pixels where both see the same surface, the result is the kTrustedShare
// quantile (by solid angle) of the difference, divided by sqrt(2) because both maps have
// independent errors. Pixels occluded in one of the maps do not count, nor those of a confidence
// below kMinConfidence, which views ignore. Errors common to all maps (such as a wrong scale) are
// not detected. None if the room has fewer than two maps or they have no surface in common.
std::optional<double> inverse_error(const Room& room);

// The conditions that the sizes have to satisfy.
struct StorageNeed {
  double reach_m = 0.0;        // from viewpoint to line
  double spacing_m = 0.0;      // of the stations in use
  double tolerance_px = 0.5;   // at the panorama's width
  double inverse_error = 0.0;  // 1/m, of the distances
  InverseRange scene{};        // inverse distances
};

// The panorama width, pixels, at which the residual parallax equals `tolerance_px` of its own
// pixels; infinity if there is none. An error e of an inverse distance leaves up to reach * e in
// latitude (the slope of (5), see layer_count.h) and, at right angles, spacing / 2 * e along the
// rail (half the ghost, see spacing.h). A wider panorama would store detail that views displace by
// more than the tolerance.
double useful_width(const StorageNeed& need);

// Higher than kTrustedShare, because coarse maps lose silhouettes, where views
// tear. In white-room, maps that kept 97.6 % and 99.1 % cost hlf-vd views 3.2 dB and 1.4 dB,
// two-sided views 1.2 dB and 0.4 dB. The loss is proportional to the wrong share, so 0.2 % cost
// about 0.3 dB.
inline constexpr double kKeptShare = 0.998;

struct DistanceWidth {
  int width_px = 0;
  double share_within_tolerance = 1.0;  // of the solid angle
};

// The smallest width, halving from that of the maps, at which (as at all larger ones) the
// displacement reach * |error of inverse| is within the tolerance for kKeptShare of the solid angle
// of a sample of maps. Coarse maps are interpolated as in distance_maps.h.
DistanceWidth distance_width_needed(const Room& room, const StorageNeed& need);

// Widths, precision and bytes; `stations_needed` is the number of stations to keep.
StorageFacts storage_facts(const Room& room, const StorageNeed& need, int stations_needed);

}  // namespace raywalk::build_lf
