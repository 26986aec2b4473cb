// The shared main() of the Raywalk executables: handles Ctrl-C, sets up logging, turns exceptions
// into one line on stderr and an exit code.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace CLI {
class App;
}

namespace raywalk {

// Parses the command line with `app`, which has the program's name, and runs the callbacks of the
// chosen subcommands, which do the work and throw on failure. Adds -q, --quiet to every command
// (command_options.h). Returns the process exit code: --help and --version give kDone, a wrong
// command line or UsageError kWrongUsage, Paused kPaused, Error and any other std::exception
// kFailed, Interrupted kInterrupted. Every failure prints exactly one line, "<program>: error:
// <what>", to stderr; that of a wrong command line names the unknown flag or command, the nearest
// valid one and the --help to read.
//
// `rewritten` may change the words before they are parsed; they lack the program's name.
using RewrittenWords = std::function<std::vector<std::string>(const std::vector<std::string>&)>;
int run_program(CLI::App& app, int argc, char** argv, const RewrittenWords& rewritten = {});

}  // namespace raywalk
