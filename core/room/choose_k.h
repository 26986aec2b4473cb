// The limit angle k of a room's hybrid connection, as `--k auto`, `require` and every report choose
// it.
#pragma once

#include <span>
#include <string>

#include "core/room/connection_errors.h"
#include "core/room/room.h"

namespace raywalk {

// Where nothing better is measured. On every room measured so far E_connect fell all the way to 90
// degrees, and views came nearest to the truth there; the optimum of the model E_t (6), 72 to 73
// degrees, was never confirmed (docs/measured.md, "Connection of lines").
inline constexpr double kUnmeasuredKDeg = 90.0;

struct ChosenK {
  double k_deg = kUnmeasuredKDeg;
  std::string source{};  // how it was chosen, for the user
};

// The k of least_error() for views of a generation (initial, hlf-vd or two-sided). A corrected
// generation without one uses that of the other corrected one, then that of the initial views.
// Initial views use their own only, because correction removes most of their connection error.
// Without any, kUnmeasuredKDeg, and the source says why.
ChosenK choose_k(std::span<const ConnectionErrorMeasurement> measurements,
                 const std::string& generation);

// The same from the room's stored measurements. A room without cells has no connections; its k is
// 90. Throws Error as read_connection_errors.
ChosenK choose_k(const Room& room, const std::string& generation);

}  // namespace raywalk
