// Work on several threads, what of it is kept, and how it is interrupted.
#include "core/base/parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/recently_made.h"
#include "core/base/test_error.h"

namespace raywalk {
namespace {

using ::testing::ElementsAre;
using ::testing::Pointee;

TEST(ParallelFor, VisitsEveryIndexOnceInChunksOfAtMostTheGrain) {
  for (const int grain : {-3, 0, 1, 7, 64, 5000}) {
    std::vector<std::atomic<int>> visits(1000);
    std::atomic<int> longest{0};
    parallel_for(10, 1000, grain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
      int seen = longest;
      while (seen < end - begin && !longest.compare_exchange_weak(seen, end - begin)) {
      }
    });
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(visits[static_cast<std::size_t>(i)], i < 10 ? 0 : 1) << i << " grain " << grain;
    }
    EXPECT_LE(longest, std::max(grain, 1));
  }
}

TEST(ParallelFor, EmptyRangeMakesNoCalls) {
  const auto fail = [](int, int) { FAIL() << "called"; };
  parallel_for(3, 3, 1, fail);
  parallel_for(3, -3, 1, fail);
}

TEST(ParallelFor, ExceptionOfTheBodyReachesTheCaller) {
  EXPECT_THROW(parallel_for(0, 100, 1,
                            [](int begin, int) {
                              if (begin == 57) throw Error("left_057.jpg: cut short");
                            }),
               Error);
}

// What the inner loop should have made would be used.
TEST(ParallelFor, AnInnerLoopWhoseOuterOneFailedDoesNotReturnAsIfDone) {
  if (thread_count() < 2) GTEST_SKIP() << "needs two threads";
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const auto in_time = [&] { return std::chrono::steady_clock::now() < end; };
  std::atomic<bool> inside = false, left_out = false;
  const auto body = [&](int begin, int) {
    if (begin == 1) {
      while (!inside && in_time()) std::this_thread::yield();
      throw Error("left_057.jpg: cut short");
    }
    inside = true;
    while (!left_out && in_time()) {
      bool made = false;
      parallel_for(0, 1, 1, [&](int, int) { made = true; });
      left_out = !made;
    }
  };
  EXPECT_THROW(parallel_for(0, 2, 1, body), Error);
  EXPECT_FALSE(left_out);
}

// In a process of its own, as outside of WatchInterrupts a signal is remembered for good.
template <typename Condition>
void expect_in_own_process(const Condition& holds) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::exit(holds() ? 42 : 1), testing::ExitedWithCode(42), "");
}

bool is_interrupted(const std::function<void()>& work) {
  try {
    work();
  } catch (const Interrupted&) {
    return true;
  }
  return false;
}

TEST(ParallelForDeathTest, CtrlCEndsTheLoop) {
  expect_in_own_process([] {
    install_interrupt_handlers();
    set_thread_count(1);
    int chunks = 0;
    const auto third_raises = [&](int, int) {
      if (++chunks == 3) std::raise(SIGINT);
    };
    return is_interrupted([&] { parallel_for(0, 100, 1, third_raises); }) && chunks == 3;
  });
}

TEST(ThreadCount, LimitsLoopsAndOpenCvAlikeAndIsNotNegative) {
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), 1);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), thread_count());
  EXPECT_THROW(set_thread_count(-1), UsageError);
}

TEST(CheckInParallel, TheFirstFailureIsReportedWhateverTheOrder) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    std::atomic<int> checked = 0;
    const auto check = [&](int i) {
      ++checked;
      if (i == 417 || i == 3 || i > 900) throw Error(std::to_string(i));
    };
    EXPECT_EQ(error_of([&] { check_in_parallel(1000, check); }), "3");
    EXPECT_LE(checked, 1000);
  }
  std::atomic<int> sum = 0;
  check_in_parallel(100, [&](int i) { sum += i; });
  EXPECT_EQ(sum, 4950);
}

TEST(RecentlyMadeTest, KeepsTheValuesUsedLast) {
  std::vector<int> made;
  RecentlyMade<int, std::string> values(2, [&](int key) {
    made.push_back(key);
    return std::to_string(key);
  });
  for (const int key : {1, 2, 1, 3, 1, 2}) EXPECT_EQ(*values.get(key), std::to_string(key));
  EXPECT_THAT(made, ElementsAre(1, 2, 3, 2));
}

TEST(RecentlyMadeTest, GivesManyAtOnceInTheirOrderEvenMoreThanAreKept) {
  std::atomic<int> made = 0;
  RecentlyMade<int, int> values(2, [&](int key) {
    ++made;
    return 10 * key;
  });
  const auto held = values.get(4);
  const std::vector<int> keys{4, 0, 1, 2};
  EXPECT_THAT(values.get_all(keys), ElementsAre(held, Pointee(0), Pointee(10), Pointee(20)));
  EXPECT_EQ(made, 4);
  EXPECT_EQ(*held, 40);
  EXPECT_TRUE(values.get_all({}).empty());
}

TEST(RecentlyMadeTest, CanBeUsedBySeveralThreads) {
  RecentlyMade<int, int> values(2, [](int key) { return 10 * key; });
  parallel_for(0, 40, 1,
               [&](int begin, int) { EXPECT_EQ(*values.get(begin % 5), 10 * (begin % 5)); });
}

TEST(InterruptDeathTest, EverySignalToStopIsThrownAsInterrupted) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    expect_in_own_process([&] {
      install_interrupt_handlers();
      std::raise(signal);
      return is_interrupted(throw_if_interrupted) && interrupt_requested();
    });
  }
}

TEST(InterruptDeathTest, SighupIgnoredByNohupStaysIgnored) {
  expect_in_own_process([] {
    std::signal(SIGHUP, SIG_IGN);
    install_interrupt_handlers();
    std::raise(SIGHUP);
    {
      const DeferStopSignals protection;
      std::raise(SIGHUP);
    }
    std::raise(SIGHUP);
    return !interrupt_requested();
  });
}

TEST(InterruptDeathTest, SecondSigintEndsTheProcessAtOnce) {
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(InterruptDeathTest, DeferredSignalsDoNotEndTheProcessUntilHandlersAreRestored) {
  expect_in_own_process([] {
    install_interrupt_handlers();
    const DeferStopSignals protection;
    for (const int signal : {SIGINT, SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::raise(signal);
    return interrupt_requested();
  });
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

TEST(InterruptDeathTest, WatchedSigintStopsWorkAndReachesTheHost) {
  expect_in_own_process([] {
    std::signal(SIGINT, count_signal);
    {
      const WatchInterrupts outer;
      {
        const WatchInterrupts inner;
        std::raise(SIGINT);
      }
      if (!interrupt_requested()) return false;
    }
    if (interrupt_requested()) return false;
    std::raise(SIGINT);  // of the host alone
    return !interrupt_requested() && host_signals == 2;
  });
}

TEST(InterruptDeathTest, WatchedSigintWithoutAHandlerEndsTheProcess) {
  EXPECT_EXIT(
      {
        const WatchInterrupts watch;
        std::raise(SIGINT);
        std::exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(InterruptDeathTest, WatchingWaitsForWorkThatWasInterrupted) {
  expect_in_own_process([] {
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
    return !stops;
  });
}

}  // namespace
}  // namespace raywalk
