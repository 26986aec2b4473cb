// A serial line: exclusive use of its port, and waiting for silence on it, so that no old reply is
// taken for a new one.
#pragma once

#include <string>

#include "capture/base/clock.h"

namespace raywalk::capture {

// Exclusive use: two masters on one line would corrupt each other's requests.
class PortLock {
 public:
  // Opens the port and locks it with flock, which cooperating programs respect (pyserial, picocom
  // and this one). refuse_others adds TIOCEXCL against all others. Throws DeviceFault kNoContact:
  // no such port, no permission, not a serial port, in use.
  explicit PortLock(const std::string& device);
  ~PortLock();
  PortLock(const PortLock&) = delete;
  PortLock& operator=(const PortLock&) = delete;

  // Makes every later open() of the port fail, except by root. Not done by the constructor, because
  // it would also refuse the second descriptor that libmodbus opens. No effect on pseudo-terminals.
  void refuse_others();

 private:
  int fd_ = -1;
};

enum class LineState { kQuiet, kNeverQuiet, kGone };

// Reads and drops bytes from a non-blocking descriptor until none has arrived for `quiet`. Returns
// kNeverQuiet after `patience`, kGone if the other end has closed. Uses the machine's clock: bytes
// arrive in real time even if the carriage runs on simulated time.
LineState wait_until_quiet(int fd, Duration quiet, Duration patience);

// The silence that ends a frame on a serial line: 3.5 characters of 11 bits, and 1.75 ms above
// 19200 baud (Modbus over serial line 1.02, 2.5.1.1).
Duration frame_gap(int baud);

}  // namespace raywalk::capture
