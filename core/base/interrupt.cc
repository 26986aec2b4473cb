#include "core/base/interrupt.h"

#include <atomic>
#include <csignal>

#include "core/base/error.h"

namespace raywalk {
namespace {

// A signal handler may only access lock-free atomics ([support.signal]).
std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void request_stop(int /*signal*/) { stop_requested.store(true); }

// Returns the previous action.
struct sigaction install(int signal, int flags) {
  struct sigaction action = {};
  action.sa_handler = request_stop;
  sigemptyset(&action.sa_mask);
  action.sa_flags = flags;
  struct sigaction before = {};
  sigaction(signal, nullptr, &before);
  const bool survives_logout = signal == SIGHUP && before.sa_handler == SIG_IGN;
  if (!survives_logout) sigaction(signal, &action, nullptr);
  return before;
}

}  // namespace

void install_interrupt_handlers() {
  // SA_RESETHAND restores the default after the first SIGINT, so the second one kills the process
  // by SIGINT, which shells report as 130.
  install(SIGINT, SA_RESTART | SA_RESETHAND);
  install(SIGTERM, SA_RESTART);
  install(SIGHUP, SA_RESTART);
}

DeferStopSignals::DeferStopSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) before_[i] = install(kSignals[i], SA_RESTART);
}

DeferStopSignals::~DeferStopSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

bool interrupt_requested() { return stop_requested.load(std::memory_order_relaxed); }

void throw_if_interrupted() {
  if (interrupt_requested()) throw Interrupted("interrupted");
}

}  // namespace raywalk
