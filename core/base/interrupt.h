// Ctrl-C as a flag that long work polls, so that it can stop cleanly.
#pragma once

#include <array>
#include <csignal>

namespace raywalk {

// Installs handlers for SIGINT, SIGTERM and SIGHUP that set a flag; a second SIGINT ends the
// process at once. Where SIGHUP is ignored (nohup) it stays ignored.
void install_interrupt_handlers();

// While one exists, SIGINT, SIGTERM, SIGHUP (unless ignored) and SIGQUIT only set the flag, however
// often they arrive: for work that must not be killed, such as moving a motor. Only one may exist
// at a time.
class DeferStopSignals {
 public:
  DeferStopSignals();
  ~DeferStopSignals();
  DeferStopSignals(const DeferStopSignals&) = delete;
  DeferStopSignals& operator=(const DeferStopSignals&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT};
  std::array<struct sigaction, kSignals.size()> before_{};
};

// For work inside of a program with a SIGINT handler of its own, such as Python's: while one
// exists, SIGINT sets the flag and then calls that handler. Where SIGINT is ignored or ends the
// process, it stays so. Several may exist, also on several threads: the flag stops the work of all,
// and the last to end clears it. A new one waits for that, so that it does not stop for a signal
// before its time.
class WatchInterrupts {
 public:
  WatchInterrupts();
  ~WatchInterrupts();
  WatchInterrupts(const WatchInterrupts&) = delete;
  WatchInterrupts& operator=(const WatchInterrupts&) = delete;
};

// Whether the user has asked to stop.
bool interrupt_requested();

// Throws Interrupted if the user has asked to stop. Safe from any thread; cheap enough for every
// frame.
void throw_if_interrupted();

}  // namespace raywalk
