#include "core/base/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <memory>
#include <thread>

#include "core/base/error.h"

namespace raywalk {
namespace {

// Outside of WatchInterrupts the flag is never reset, so each test that raises a signal runs in its
// own process.
class InterruptDeathTest : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST(Interrupt, NothingIsThrownWithoutASignal) {
  EXPECT_FALSE(interrupt_requested());
  EXPECT_NO_THROW(throw_if_interrupted());
}

void stop_in_good_order_after(int signal) {
  install_interrupt_handlers();
  std::raise(signal);
  try {
    throw_if_interrupted();
  } catch (const Interrupted&) {
    std::exit(interrupt_requested() ? 42 : 1);
  }
  std::exit(2);
}

TEST_F(InterruptDeathTest, EverySignalToStopIsThrownAsInterrupted) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EXIT(stop_in_good_order_after(signal), testing::ExitedWithCode(42), "") << signal;
  }
}

TEST_F(InterruptDeathTest, SighupIgnoredByNohupStaysIgnored) {
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        install_interrupt_handlers();
        std::raise(SIGHUP);
        {
          const DeferStopSignals protection;
          std::raise(SIGHUP);
        }
        std::raise(SIGHUP);
        std::exit(interrupt_requested() ? 1 : 42);
      },
      testing::ExitedWithCode(42), "");
}

TEST_F(InterruptDeathTest, SecondSigintEndsTheProcessAtOnce) {
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST_F(InterruptDeathTest, DeferredSignalsDoNotEndTheProcess) {
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        const DeferStopSignals protection;
        for (const int signal : {SIGINT, SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::raise(signal);
        std::exit(interrupt_requested() ? 42 : 1);
      },
      testing::ExitedWithCode(42), "");
}

TEST_F(InterruptDeathTest, HandlersAreRestoredAfterwards) {
  EXPECT_EXIT(
      {
        { const DeferStopSignals protection; }
        std::raise(SIGHUP);
        std::exit(0);
      },
      testing::KilledBySignal(SIGHUP), "");
}

// A host program's own handler.
volatile std::sig_atomic_t host_signals = 0;
void count_signal(int /*signal*/) { host_signals = host_signals + 1; }

TEST_F(InterruptDeathTest, WatchedSigintStopsWorkAndReachesTheHost) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, count_signal);
        {
          const WatchInterrupts outer;
          {
            const WatchInterrupts inner;
            std::raise(SIGINT);
          }
          if (!interrupt_requested()) std::exit(1);
        }
        if (interrupt_requested()) std::exit(2);
        std::raise(SIGINT);  // of the host alone
        std::exit(interrupt_requested() ? 3 : 40 + host_signals);
      },
      testing::ExitedWithCode(42), "");
}

TEST_F(InterruptDeathTest, WatchedSigintWithoutAHandlerEndsTheProcess) {
  EXPECT_EXIT(
      {
        const WatchInterrupts watch;
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST_F(InterruptDeathTest, WatchingWaitsForWorkThatWasInterrupted) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, count_signal);
        auto interrupted = std::make_unique<WatchInterrupts>();
        std::raise(SIGINT);
        bool stops = true;
        std::thread later([&stops] {
          const WatchInterrupts watch;
          stops = interrupt_requested();
        });
        interrupted.reset();
        later.join();
        std::exit(stops ? 1 : 42);
      },
      testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace raywalk
