// For tests: keeps the number of a pseudo-terminal taken.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <string>

namespace raywalk::capture {

// The kernel gives the number of a terminal to the next program that asks once both of its sides
// are closed, so that a link that tries to come back after a hang-up would meet another test's
// device there. While this holds the terminal open, such a link finds it dead.
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
