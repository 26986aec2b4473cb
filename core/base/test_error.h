// For tests: what an action says when it fails.
#pragma once

#include <string>

#include "core/base/error.h"

namespace raywalk {

// The message of the Error that `action` throws, "no error" if it throws none.
template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace raywalk
