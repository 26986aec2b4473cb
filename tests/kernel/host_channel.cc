#include "tests/kernel/host_channel.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "tests/kernel/check_report.h"

namespace raywalk::capture {
namespace {

// Starting a slave includes loading Python's libraries, possibly on a busy machine.
constexpr int kTimeout_ms = 60000;

}  // namespace

HostChannel::HostChannel(const std::string& device)
    : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  require(fd_ >= 0, "cannot open " + device);
  termios settings{};
  tcgetattr(fd_, &settings);
  cfmakeraw(&settings);
  tcsetattr(fd_, TCSANOW, &settings);
}

HostChannel::~HostChannel() { close(fd_); }

int HostChannel::ask(const std::string& order) {
  const std::string line = order + "\n";
  require(write(fd_, line.data(), line.size()) == static_cast<ssize_t>(line.size()),
          "cannot write to the host's port");
  const std::string answer = read_line();
  require(answer.starts_with("done "), "the host failed to execute '" + order + "': " + answer);
  return std::stoi(answer.substr(5));
}

std::string HostChannel::read_line() {
  std::string line;
  for (;;) {
    pollfd input{.fd = fd_, .events = POLLIN, .revents = 0};
    require(poll(&input, 1, kTimeout_ms) > 0, "no reply from the host");
    char letter = 0;
    require(read(fd_, &letter, 1) == 1, "the host's port was closed");
    if (letter == '\n') return line;
    line += letter;
  }
}

}  // namespace raywalk::capture
