// For tests: keeps the number of a pseudo-terminal in use.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <string>

namespace raywalk::capture {

// Once both sides of a terminal are closed, the kernel reuses its number. A link that reconnects
// after a hang-up would then reach the device of another test. While this object holds the terminal
// open, such a link finds it closed.
class TerminalReservation {
 public:
  explicit TerminalReservation(const std::string& device)
      : terminal_(open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {}
  ~TerminalReservation() {
    if (terminal_ >= 0) close(terminal_);
  }
  TerminalReservation(const TerminalReservation&) = delete;
  TerminalReservation& operator=(const TerminalReservation&) = delete;

 private:
  int terminal_;
};

}  // namespace raywalk::capture
