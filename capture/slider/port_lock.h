// One program at a time on a serial port: two masters on one line garble each other's requests.
#pragma once

#include <string>

namespace raywalk::capture {

class PortLock {
 public:
  // Opens the port and locks it: flock against other programs that ask (as pyserial, picocom and
  // this one do); TIOCEXCL, by refuse_others, against those that do not.
  // Throws DeviceFault kNoContact: no such port, no permission, no serial port, in use.
  explicit PortLock(const std::string& device);
  ~PortLock();
  PortLock(const PortLock&) = delete;
  PortLock& operator=(const PortLock&) = delete;

  // Keeps every later open by others out, except for root's, whom Linux lets pass. Not done at
  // construction, where it would keep out the second descriptor that this program itself opens.
  // Without effect on pseudo-terminals.
  void refuse_others();

 private:
  int fd_ = -1;
};

}  // namespace raywalk::capture
