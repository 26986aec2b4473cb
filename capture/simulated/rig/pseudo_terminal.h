// A serial port that exists only in the computer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "capture/simulated/rig/link_faults.h"

namespace raywalk::capture {

// The master side of a pseudo-terminal; a client opens the other side by a symbolic link. A client
// may close it and another one open it any number of times: the slave side is held open here too,
// as the master would else see nothing but EIO between two clients.
class PseudoTerminal {
 public:
  // Makes the link, in place of an earlier link of that name. Throws Error: no terminal to be had,
  // the name is taken by something else, its directory is missing.
  explicit PseudoTerminal(const std::filesystem::path& link);
  // Hangs up: the client reads an end of file or EIO. Takes the link away.
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  int descriptor() const { return master_; }  // to poll; does not block
  // What a client has written; empty if nothing.
  ModbusBytes read();
  // What does not fit, as nobody reads, is lost: a serial line does not wait either.
  void write(std::span<const std::uint8_t> bytes);
  // Ends the exclusive use (TIOCEXCL) that a client asked for. It would outlive the client, since
  // the terminal stays open here, and shut out the next one for ever.
  void lift_exclusion();

 private:
  void make_link();

  std::filesystem::path link_;
  std::filesystem::path terminal_;
  int master_ = -1;
  int slave_ = -1;
};

}  // namespace raywalk::capture
