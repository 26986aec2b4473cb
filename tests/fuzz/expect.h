// Checks the error contract of the readers on fuzzed input.
#pragma once

#include <cstdlib>
#include <iostream>
#include <string_view>

#include "core/base/error.h"

namespace raywalk {

// Aborts, which libFuzzer reports with the input, unless the message is one line.
inline void expect_one_line(const Error& error) {
  const std::string_view message = error.what();
  if (!message.empty() && message.find('\n') == std::string_view::npos) return;
  std::cerr << "not one line: " << message << std::endl;
  std::abort();
}

}  // namespace raywalk
