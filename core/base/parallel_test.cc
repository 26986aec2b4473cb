#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/test_error.h"

namespace raywalk {
namespace {

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

TEST(ParallelFor, CtrlCEndsTheLoop) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        set_thread_count(1);
        int chunks = 0;
        try {
          parallel_for(0, 100, 1, [&](int, int) {
            if (++chunks == 3) std::raise(SIGINT);
          });
        } catch (const Interrupted&) {
          std::exit(chunks == 3 ? 42 : 1);
        }
        std::exit(2);
      },
      testing::ExitedWithCode(42), "");
}

TEST(ThreadCount, LimitsLoopsAndOpenCvAlike) {
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), 1);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  EXPECT_EQ(cv::getNumThreads(), thread_count());
}

TEST(ThreadCount, NegativeCountIsWrongUsage) { EXPECT_THROW(set_thread_count(-1), UsageError); }

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

}  // namespace
}  // namespace raywalk
