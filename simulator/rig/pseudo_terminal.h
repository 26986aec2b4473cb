// A pseudo-terminal that serves as a simulated serial port.
#pragma once

#include <filesystem>

namespace raywalk::capture {

// The master side of a pseudo-terminal; clients open the other side through a symbolic link. The
// slave side is also held open here, so that clients may close and reopen it: otherwise the master
// would read EIO while no client is connected.
class PseudoTerminal {
 public:
  // Creates the symbolic link, replacing an existing link of that name. Throws Error if no terminal
  // is available, the name belongs to something else or its directory is missing.
  explicit PseudoTerminal(const std::filesystem::path& link);
  // Hangs up, so that the client reads end of file or EIO, and removes the link.
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  // Non-blocking: bytes that do not fit its buffer are lost, as on a serial line.
  int descriptor() const { return master_; }
  // Clears the exclusive mode (TIOCEXCL) set by a client. As the terminal stays open here, it would
  // otherwise outlast the client and lock out the next one.
  void lift_exclusion() const;

 private:
  std::filesystem::path link_;
  std::filesystem::path terminal_;
  int master_ = -1;
  int slave_ = -1;
};

}  // namespace raywalk::capture
