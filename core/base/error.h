// Errors that end a command, and the exit codes of every Raywalk program.
//
// Library code throws; `run_program` (program.h) is the one place that turns an exception into one
// line on stderr and an exit code. A message is a single line that says what is wrong, where, and
// what to do.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace raywalk {

enum class ExitCode : int {
  kDone = 0,
  kFailed = 1,        // bad input, unwritable output, a device that failed
  kWrongUsage = 2,    // wrong command line or configuration
  kPaused = 3,        // stopped cleanly, can be resumed
  kInterrupted = 130  // Ctrl-C
};

// Bad input, a failed device or a failed system call; exit code kFailed.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A wrong command line or configuration file; exit code kWrongUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

// A session stopped cleanly because the operator has to fix something first; the same command
// resumes it. Exit code kPaused.
class Paused : public Error {
 public:
  using Error::Error;
};

// The user interrupted the program (Ctrl-C); exit code kInterrupted. Stages that can resume keep
// their finished work.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The words of a library, a device or a damaged file on one line: every run of line breaks, tabs
// and spaces becomes one space, trimmed at both ends; the rest as escaped() shows it (escaped.h).
// Not for whole messages, whose file names would be changed: run_program escapes them.
std::string one_line(std::string_view text);

// File content quoted in an error message: escaped(text), cut to 60 bytes, in single quotes.
std::string excerpt(std::string_view text);

}  // namespace raywalk
