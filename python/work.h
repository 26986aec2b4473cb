// How a call from Python does its work: without the interpreter's lock, so that other threads of
// Python go on; ended by Ctrl-C; with warnings as Python's own.
#pragma once

#include <pybind11/pybind11.h>

#include <type_traits>

#include "core/base/interrupt.h"

namespace raywalk::python {

// Silences progress, and collects warnings. Call once, when the module is imported.
void collect_warnings();

// Hands the collected warnings to Python as RuntimeWarning. Throws where Python makes them errors.
void issue_warnings();
void drop_warnings();

// The result of work(), which must not touch Python's objects but the memory of arrays that the
// caller holds. Throws Interrupted also where it was too late to stop the work: a thread that does
// one short piece of work after the other is to stop, too.
template <typename Work>
std::invoke_result_t<Work> without_lock(Work work) {
  const auto unlocked = [&work] {
    const pybind11::gil_scoped_release released;
    const WatchInterrupts watch;
    auto result = work();
    throw_if_interrupted();
    return result;
  };
  try {
    auto result = unlocked();
    issue_warnings();
    return result;
  } catch (...) {
    drop_warnings();
    throw;
  }
}

}  // namespace raywalk::python
