// Ends a Ceres solver when the user asks to stop.
#pragma once

#include <ceres/iteration_callback.h>

#include "core/base/interrupt.h"

namespace raywalk::calibrate {

// A callback for Solver::Options::callbacks that aborts the solver after the iteration during which
// the user asked to stop (interrupt_requested). Call throw_if_interrupted after ceres::Solve: the
// aborted solution is of no use.
class StopOnInterrupt final : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return interrupt_requested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
};

}  // namespace raywalk::calibrate
