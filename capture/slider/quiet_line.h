// Waiting for silence on a line, so that no old reply is taken for a new one.
#pragma once

#include "capture/base/clock.h"

namespace raywalk::capture {

enum class LineState { kQuiet, kNeverQuiet, kGone };

// Reads and drops bytes from a non-blocking descriptor until none has arrived for `quiet`. Returns
// kNeverQuiet after `patience`, kGone if the other end has closed. Uses the machine's clock: bytes
// arrive in real time even if the carriage runs on simulated time.
LineState wait_until_quiet(int fd, Duration quiet, Duration patience);

// The silence that ends a frame on a serial line: 3.5 characters of 11 bits, and 1.75 ms above
// 19200 baud (Modbus over serial line 1.02, 2.5.1.1).
Duration frame_gap(int baud);

}  // namespace raywalk::capture
