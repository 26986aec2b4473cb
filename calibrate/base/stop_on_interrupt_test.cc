#include "calibrate/base/stop_on_interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace raywalk::calibrate {
namespace {

TEST(StopOnInterrupt, LetsTheSolverContinue) {
  StopOnInterrupt stop;
  EXPECT_EQ(stop(ceres::IterationSummary()), ceres::SOLVER_CONTINUE);
}

// The flag never goes back, so the signal is raised in a process of its own.
TEST(StopOnInterruptDeathTest, AbortsTheSolverAfterAnInterrupt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        std::raise(SIGINT);
        StopOnInterrupt stop;
        std::exit(stop(ceres::IterationSummary()) == ceres::SOLVER_ABORT ? 42 : 1);
      },
      testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace raywalk::calibrate
