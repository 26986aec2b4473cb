// For the kernel's tests: what has to hold for a test to go on, in helpers that return something.
#pragma once

#include <stdexcept>
#include <string>

namespace raywalk::capture {

// Throws if it does not hold, which fails the test.
inline void require(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what);
}

}  // namespace raywalk::capture
