// For tests: runs a shell command and captures its output.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {

struct CommandResult {
  int exit_code = -1;  // 128 + signal if terminated by a signal
  std::string output;  // stdout
  std::string errors;  // stderr
};

inline CommandResult run_command(const std::string& command) {
  const TestDirectory directory;
  const auto out = directory / "out", err = directory / "err";
  const std::string redirected =
      "( " + command + " ) > " + out.string() + " 2> " + err.string() + " < /dev/null";
  const int status = std::system(redirected.c_str());
  CommandResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.output = read_file(out);
  result.errors = read_file(err);
  return result;
}

}  // namespace raywalk
