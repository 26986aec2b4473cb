// The line to serial_host.py, which stands for the operator's hands: it damages, cuts and unplugs.
#pragma once

#include <string>

namespace raywalk::capture {

class HostChannel {
 public:
  // Throws CheckFailure where the port cannot be opened.
  explicit HostChannel(const std::string& device);
  ~HostChannel();
  HostChannel(const HostChannel&) = delete;
  HostChannel& operator=(const HostChannel&) = delete;

  // Sends one order (serial_host.py lists them) and waits until it is done; returns the number that
  // comes with the answer. Throws CheckFailure where no answer comes.
  int ask(const std::string& order);

 private:
  std::string read_line();

  int fd_;
};

}  // namespace raywalk::capture
