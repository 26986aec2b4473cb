#include "core/base/interrupt.h"

#include <atomic>
#include <condition_variable>
#include <csignal>
#include <mutex>

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

// What WatchInterrupts share. `count` of them exist.
struct Watch {
  std::mutex mutex{};
  std::condition_variable ended{};
  int count = 0;
};

Watch& watch() {
  static Watch shared;
  return shared;
}

// The action that SIGINT had before it was watched; written only while it is not.
struct sigaction watched_action = {};

extern "C" void request_stop_and_go_on(int signal, siginfo_t* info, void* context) {
  stop_requested.store(true);
  if ((watched_action.sa_flags & SA_SIGINFO) != 0) {
    watched_action.sa_sigaction(signal, info, context);
  } else {
    watched_action.sa_handler(signal);
  }
}

bool is_watching(const struct sigaction& action) {
  return (action.sa_flags & SA_SIGINFO) != 0 && action.sa_sigaction == request_stop_and_go_on;
}

void begin_to_watch() {
  sigaction(SIGINT, nullptr, &watched_action);
  const bool has_handler =
      (watched_action.sa_flags & SA_SIGINFO) != 0 ||
      (watched_action.sa_handler != SIG_DFL && watched_action.sa_handler != SIG_IGN);
  if (!has_handler) return;
  struct sigaction action = watched_action;
  action.sa_sigaction = request_stop_and_go_on;
  action.sa_flags |= SA_SIGINFO;
  sigaction(SIGINT, &action, nullptr);
}

void end_to_watch() {
  struct sigaction now = {};
  sigaction(SIGINT, nullptr, &now);
  // Otherwise somebody has set another handler meanwhile, which stays.
  if (is_watching(now)) sigaction(SIGINT, &watched_action, nullptr);
  stop_requested.store(false);
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

WatchInterrupts::WatchInterrupts() {
  std::unique_lock lock(watch().mutex);
  watch().ended.wait(lock, [] { return watch().count == 0 || !interrupt_requested(); });
  if (watch().count++ == 0) begin_to_watch();
}

WatchInterrupts::~WatchInterrupts() {
  {
    const std::lock_guard lock(watch().mutex);
    if (--watch().count == 0) end_to_watch();
  }
  watch().ended.notify_all();
}

bool interrupt_requested() { return stop_requested.load(std::memory_order_relaxed); }

void throw_if_interrupted() {
  if (interrupt_requested()) throw Interrupted("interrupted");
}

}  // namespace raywalk
