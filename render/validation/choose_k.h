// `--k auto`: the limit angle of the hybrid connection that suits a room best.
#pragma once

#include <string>

#include "core/room/requirements.h"
#include "core/room/room.h"
#include "render/view/renderer.h"

namespace raywalk::render {

struct AutoK {
  double k_deg = 90.0;
  std::string source{};  // where it comes from, in words
};

// The first of these that the room has:
// 1. The k of least E_connect (the largest of equals) of a stored measurement
//    (core/room/connection_errors.h). A corrected generation that was not measured itself goes by
//    the other corrected one, then by the initial views; initial views go by their own measurement
//    only, because the correction takes away most of what they are judged by.
// 2. What `required` recommends, where it is given: the measurement it remembers, chosen in the
//    same way, else its k of least E_t.
// 3. The k of least E_t (6) over the room's distances (core/room/connection_model.h).
// 4. The k of least E_t at d_src = 1.5 N, as the paper does.
// A room without cells connects nothing; its k is 90. Throws Error for a damaged measurement.
AutoK auto_k_deg(const Room& room, Generation generation,
                 const RoomRequirements* required = nullptr);

}  // namespace raywalk::render
