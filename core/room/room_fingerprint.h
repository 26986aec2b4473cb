// Detects whether a room has changed since earlier results were made from it.
#pragma once

#include <string>

#include "core/room/room.h"

namespace raywalk {

// A hexadecimal SHA-256 that changes when the rays or the distance maps of a room do. Distance
// files are never modified in place, so a replaced one has another size or modification time.
std::string room_fingerprint(const Room& room);

}  // namespace raywalk
