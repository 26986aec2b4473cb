// Waiting until nothing comes in any more, so that no old reply is taken for a new one.
#pragma once

#include "capture/base/clock.h"

namespace raywalk::capture {

enum class LineState { kQuiet, kNeverQuiet, kGone };

// Reads and drops what comes in on a non-blocking descriptor until nothing came for `quiet`; gives
// up `patience` after the call. kGone: the other end has closed it. This waits on the machine's own
// clock: bytes arrive in real time also where the carriage runs on a simulated one.
LineState wait_until_quiet(int fd, Duration quiet, Duration patience);

// The pause that ends a frame on a serial line: 3.5 characters of 11 bits, and 1.75 ms above 19200
// baud (Modbus over serial line 1.02, 2.5.1.1).
Duration frame_gap(int baud);

}  // namespace raywalk::capture
