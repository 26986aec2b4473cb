// Checks that run one after another and print a line each. No GoogleTest: the order matters, since
// the drivers keep their state, and a virtual machine's console is read by people.
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
  // Prints "ok NAME", or "FAIL NAME: why" where `check` throws; goes on in either case.
  void run(const std::string& name, const std::function<void()>& check);

  int passed() const { return passed_; }
  int failed() const { return failed_; }

 private:
  int passed_ = 0;
  int failed_ = 0;
};

// Throws CheckFailure where it does not hold.
void require(bool holds, const std::string& what);
void require_near(double value, double expected, double tolerance, const std::string& what);

// Throws CheckFailure unless `call` throws a DeviceFault of that kind, whose message is one line,
// says `words`, and, after a semicolon, what to do.
void require_fault(FaultKind kind, const std::string& words, const std::function<void()>& call);

}  // namespace raywalk::capture
