#include "simulator/rig/pseudo_terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::capture {

namespace fs = std::filesystem;

PseudoTerminal::PseudoTerminal(const fs::path& link) : link_(link) {
  std::array<char, 128> name{};
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ >= 0 && grantpt(master_) == 0 && unlockpt(master_) == 0 &&
      ptsname_r(master_, name.data(), name.size()) == 0) {
    terminal_ = name.data();
    slave_ = open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  try {
    if (slave_ < 0) {
      throw Error("cannot create a pseudo-terminal: " + std::generic_category().message(errno));
    }
    termios settings{};
    tcgetattr(slave_, &settings);
    cfmakeraw(&settings);
    tcsetattr(slave_, TCSANOW, &settings);
    make_link();
  } catch (...) {
    close_sides();
    throw;
  }
}

// Created under another name and renamed, so that the link never disappears.
void PseudoTerminal::make_link() const {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(link_, error);
  if (fs::exists(status) && !fs::is_symlink(status)) {
    throw Error(link_.string() +
                ": exists and is not a symbolic link; remove it or choose another directory");
  }
  const fs::path fresh = link_.string() + fmt::format(".{}.partial", getpid());
  fs::remove(fresh, error);
  fs::create_symlink(terminal_, fresh, error);
  if (!error) fs::rename(fresh, link_, error);
  if (error) throw Error(fmt::format("cannot create {}: {}", link_.string(), error.message()));
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  if (fs::read_symlink(link_, ignored) == terminal_) fs::remove(link_, ignored);
  close_sides();
}

void PseudoTerminal::close_sides() const {
  if (slave_ >= 0) close(slave_);
  if (master_ >= 0) close(master_);
}

void PseudoTerminal::lift_exclusion() const { ioctl(slave_, TIOCNXCL); }

}  // namespace raywalk::capture
