// Checks that run in order and print one line each. GoogleTest is not used, as the drivers keep
// state between checks and the console of the virtual machine should stay readable.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

class CheckFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class CheckReport {
 public:
  // Prints "ok NAME", or "FAIL NAME: why" if `check` throws; continues in either case.
  void run(const std::string& name, const std::function<void()>& check);

  int passed() const { return passed_; }
  int failed() const { return failed_; }

 private:
  int passed_ = 0;
  int failed_ = 0;
};

// Throw CheckFailure if the condition is not met.
void require(bool holds, const std::string& what);
void require_near(double value, double expected, double tolerance, const std::string& what);

// Throws CheckFailure unless `call` throws a DeviceFault of this kind with a one-line message that
// contains `words` and, after a semicolon, a remedy.
void require_fault(FaultKind kind, const std::string& words, const std::function<void()>& call);

}  // namespace raywalk::capture
