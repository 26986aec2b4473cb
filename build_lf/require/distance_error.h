// Estimates the error of a room's distances from the disagreement between its maps.
#pragma once

#include <optional>

#include "core/room/room.h"

namespace raywalk::build_lf {

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
