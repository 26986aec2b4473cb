#include "simulator/rig/pseudo_terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::capture {

namespace fs = std::filesystem;

PseudoTerminal::PseudoTerminal(const fs::path& link) : link_(link) {
  if (openpty(&master_, &slave_, nullptr, nullptr, nullptr) != 0) {
    throw Error("cannot create a pseudo-terminal: " + std::generic_category().message(errno));
  }
  termios settings{};
  tcgetattr(slave_, &settings);
  cfmakeraw(&settings);
  tcsetattr(slave_, TCSANOW, &settings);
  fcntl(master_, F_SETFL, O_NONBLOCK);
  terminal_ = ptsname(master_);
  std::error_code error;
  if (fs::is_symlink(link)) fs::remove(link, error);
  fs::create_symlink(terminal_, link, error);
  if (!error) return;
  close(slave_);
  close(master_);
  throw Error(fmt::format("cannot create the link {}: {}", link.string(), error.message()));
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (fs::read_symlink(link_, ignored) == terminal_) fs::remove(link_, ignored);
  close(slave_);
  close(master_);
}

void PseudoTerminal::lift_exclusion() const { ioctl(slave_, TIOCNXCL); }

}  // namespace raywalk::capture
