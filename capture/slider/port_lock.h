// Exclusive use of a serial port: two masters on one line would corrupt each other's requests.
#pragma once

#include <string>

namespace raywalk::capture {

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

}  // namespace raywalk::capture
