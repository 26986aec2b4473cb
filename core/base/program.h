// The shared main() of the Raywalk executables: handles Ctrl-C, sets up logging, turns exceptions
// into one line on stderr and an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "core/base/error.h"

namespace raywalk {

// Parses the command line with `app` and runs the callbacks of the chosen subcommands, which do the
// work and throw on failure. Returns the process exit code: --help and --version give kDone, a
// wrong command line or UsageError kWrongUsage, Paused kPaused, Error and any other std::exception
// kFailed, Interrupted kInterrupted. Every failure prints exactly one line, "<program>: error:
// <what>", to stderr.
int run_program(CLI::App& app, int argc, char** argv);

}  // namespace raywalk
