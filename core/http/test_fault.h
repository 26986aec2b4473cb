// For tests: the status that a request is refused with.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/http/http_fault.h"

namespace raywalk {

// 0 where `action` throws nothing; expects the message to be one line.
template <typename Action>
int fault_of(const Action& action, std::string* message = nullptr) {
  try {
    action();
  } catch (const HttpFault& fault) {
    const std::string text = fault.what();
    EXPECT_FALSE(text.empty());
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    if (message != nullptr) *message = text;
    return fault.status();
  }
  return 0;
}

}  // namespace raywalk
