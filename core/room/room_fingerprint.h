// Detects whether a room has changed since earlier results were made from it.
#pragma once

#include <string>

#include "core/room/room.h"

namespace raywalk {

// A hexadecimal SHA-256 of the distances that a room's views use: over the positions and checksums
// of its maps.
std::string distances_sha256(const Room& room);

// One that changes when the rays, the distances or the gains of a room do.
std::string room_fingerprint(const Room& room);

}  // namespace raywalk
