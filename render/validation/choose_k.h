// `--k auto`: the best limit angle of the hybrid connection for a room.
#pragma once

#include <string>

#include "core/room/requirements.h"
#include "core/room/room.h"
#include "render/view/renderer.h"

namespace raywalk::render {

struct AutoK {
  double k_deg = 90.0;
  std::string source{};  // how it was chosen, for the user
};

// The first of these that the room has:
// 1. The k of least E_connect (the largest of equals) of a stored measurement
//    (core/room/connection_errors.h). A corrected generation that was not measured itself uses the
//    measurement of the other corrected one, then that of the initial views. Initial views use
//    their own measurement only, because correction removes most of their connection error.
// 2. The recommendation of `required`, where it is given: from its stored measurement in the same
//    way, else its k of least E_t.
// 3. The k of least E_t (6) over the room's distances (core/room/connection_model.h).
// 4. The k of least E_t at d_src = 1.5 N, as the paper does.
// A room without cells has no connections; its k is 90. Throws Error for a damaged measurement.
AutoK auto_k_deg(const Room& room, Generation generation,
                 const RoomRequirements* required = nullptr);

}  // namespace raywalk::render
