// Rooms as Python holds them.
#pragma once

#include <memory>

#include "core/room/room.h"

namespace raywalk::python {

// Shared with the arrays and paths that are made from it.
using SharedRoom = std::shared_ptr<Room>;

}  // namespace raywalk::python
