// Facts about a room's scene, from its distances.
#pragma once

#include <optional>

#include "core/room/requirements.h"
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
std::optional<double> omega_error(const Room& room);

}  // namespace raywalk::build_lf
