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
  kPaused = 3,        // stopped in good order, can be resumed
  kInterrupted = 130  // Ctrl-C
};

// The input or the world is at fault; exit code kFailed.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The command line or a configuration file is at fault; exit code kWrongUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

// A session stopped in good order because something outside of the program has to be put right
// first; the same command goes on afterwards. Exit code kPaused.
class Paused : public Error {
 public:
  using Error::Error;
};

// The user asked to stop; exit code kInterrupted. Work done so far is kept where a stage can
// resume.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// `text` on one line: every run of line breaks, tabs and spaces becomes one space, other control
// characters '?' (a message may carry bytes from a damaged file to a terminal); trimmed at both
// ends.
std::string one_line(std::string_view text);

// `text` as a message shows what it found in a file: one_line, cut to 60 bytes, in single quotes.
std::string excerpt(std::string_view text);

}  // namespace raywalk
