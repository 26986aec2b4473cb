// Tells whether a room is still the one that earlier results were made from.
#pragma once

#include <string>

#include "core/room/room.h"

namespace raywalk {

// SHA-256, hexadecimal, that changes when the rays or the distance maps of a room do. Distance
// files are immutable once they are there, so a replaced one shows in its size or time.
std::string room_fingerprint(const Room& room);

}  // namespace raywalk
