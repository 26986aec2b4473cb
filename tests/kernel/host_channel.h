// Connection to serial_host.py, which corrupts, cuts and unplugs the serial links on request.
#pragma once

#include <string>

namespace raywalk::capture {

class HostChannel {
 public:
  // Throws CheckFailure if the port cannot be opened.
  explicit HostChannel(const std::string& device);
  ~HostChannel();
  HostChannel(const HostChannel&) = delete;
  HostChannel& operator=(const HostChannel&) = delete;

  // Sends an order (see serial_host.py) and waits until it is done; returns the number in the
  // reply. Throws CheckFailure if the order fails or there is no reply.
  int ask(const std::string& order);

 private:
  std::string read_line();

  int fd_;
};

}  // namespace raywalk::capture
