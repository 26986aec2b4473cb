// How far the distances of a room can be trusted, told from how much its maps contradict each
// other.
#pragma once

#include <optional>

#include "core/room/room.h"

namespace raywalk::build_lf {

// The share of the pixels that errors and tolerances are stated for; the rest are silhouettes,
// reflections and thin things, which no number of this kind describes.
inline constexpr double kTrustedShare = 0.95;

// Each of some maps is looked up in the map captured nearest to it. Where both see the same
// surface, kTrustedShare of the solid angle differ by less than sqrt(2) times the result, in 1/m:
// both maps err, and independently. Differences that belong to occlusion, where one map sees
// something else, do not count. Errors that all maps share (a scale that is wrong) do not show.
// None where the room has fewer than two maps or they see nothing in common.
std::optional<double> omega_error(const Room& room);

}  // namespace raywalk::build_lf
