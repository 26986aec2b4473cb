// For tests: calls that must throw a DeviceFault.
#pragma once

#include <gmock/gmock.h>

#include <string>

#include "capture/base/device_fault.h"

namespace raywalk::capture {

// The fault that the call throws; a test failure if it throws none.
template <typename Call>
DeviceFault fault_of(const Call& call) {
  try {
    call();
  } catch (const DeviceFault& fault) {
    return fault;
  }
  ADD_FAILURE() << "no fault";
  return {FaultKind::kStall, ""};
}

// Expects a fault of this kind, whose message is one line, contains `words` and says what to do.
template <typename Call>
void expect_fault(FaultKind kind, const std::string& words, const Call& call) {
  const DeviceFault fault = fault_of(call);
  EXPECT_EQ(name_of(fault.kind()), name_of(kind)) << fault.what();
  EXPECT_THAT(fault.what(), ::testing::HasSubstr(words));
  EXPECT_THAT(fault.what(), ::testing::HasSubstr("; "));
  EXPECT_THAT(fault.what(), ::testing::Not(::testing::HasSubstr("\n")));
}

}  // namespace raywalk::capture
