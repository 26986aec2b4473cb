#include "simulator/rig/pseudo_terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

std::string system_error() { return std::generic_category().message(errno); }

void set_raw(int terminal) {
  termios settings{};
  if (tcgetattr(terminal, &settings) != 0) return;
  cfmakeraw(&settings);
  tcsetattr(terminal, TCSANOW, &settings);
}

}  // namespace

PseudoTerminal::PseudoTerminal(const fs::path& link) : link_(link) {
  std::array<char, 128> name{};
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ >= 0 && grantpt(master_) == 0 && unlockpt(master_) == 0 &&
      ptsname_r(master_, name.data(), name.size()) == 0) {
    terminal_ = name.data();
    slave_ = open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  if (slave_ < 0) {
    const std::string why = system_error();
    if (master_ >= 0) close(master_);
    throw Error("cannot create a pseudo-terminal: " + why);
  }
  set_raw(slave_);
  try {
    make_link();
  } catch (...) {
    close(slave_);
    close(master_);
    throw;
  }
}

// Created under another name and renamed, so that the link never disappears.
void PseudoTerminal::make_link() {
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
  close(slave_);
  close(master_);
}

ModbusBytes PseudoTerminal::read() {
  std::array<std::uint8_t, 512> buffer{};
  const ssize_t count = ::read(master_, buffer.data(), buffer.size());
  if (count <= 0) return {};
  return {buffer.begin(), buffer.begin() + count};
}

void PseudoTerminal::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(master_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void PseudoTerminal::lift_exclusion() { ioctl(slave_, TIOCNXCL); }

}  // namespace raywalk::capture
