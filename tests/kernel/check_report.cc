#include "tests/kernel/check_report.h"

#include <cmath>
#include <cstdio>
#include <optional>

namespace raywalk::capture {
namespace {

std::optional<DeviceFault> fault_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const DeviceFault& fault) {
    return fault;
  }
  return std::nullopt;
}

}  // namespace

void CheckReport::run(const std::string& name, const std::function<void()>& check) {
  try {
    check();
    ++passed_;
    std::printf("ok    %s\n", name.c_str());
  } catch (const std::exception& error) {
    ++failed_;
    std::printf("FAIL  %s: %s\n", name.c_str(), error.what());
  }
  std::fflush(stdout);
}

void require(bool holds, const std::string& what) {
  if (!holds) throw CheckFailure(what);
}

void require_near(double value, double expected, double tolerance, const std::string& what) {
  // NaN fails too.
  if (std::abs(value - expected) <= tolerance) return;
  throw CheckFailure(what + " is " + std::to_string(value) + ", not " + std::to_string(expected));
}

void require_fault(FaultKind kind, const std::string& words, const std::function<void()>& call) {
  const std::optional<DeviceFault> fault = fault_of(call);
  require(fault.has_value(), "no fault was reported");
  const std::string message = fault->what();
  require(fault->kind() == kind, "fault " + std::string(name_of(fault->kind())) + " instead of " +
                                     std::string(name_of(kind)) + ": " + message);
  require(message.find(words) != std::string::npos, "not about '" + words + "': " + message);
  require(message.find('\n') == std::string::npos, "more than one line: " + message);
  require(message.find("; ") != std::string::npos, "does not say what to do: " + message);
}

}  // namespace raywalk::capture
