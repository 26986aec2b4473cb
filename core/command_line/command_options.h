// Options that several commands have, under the same names and with the same meaning everywhere.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/files/shipped_configs.h"
#include "core/geometry/grid.h"

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace raywalk {

// All variables that the functions below are given have to outlive the command.

// Adds the option --threads, 0 to 1024, for set_thread_count (parallel.h); 0 means all cores.
void add_threads_option(CLI::App* command, int* threads);

// Adds the options --line-tolerance-mm and --same-station-mm, which decide how the lines of a frame
// list are found.
void add_line_tolerance_options(CLI::App* command, GridTolerance* tolerance);

// Says in the command's help that it resumes a stopped run, and where it is interrupted
// (program.h). Called after footer().
void add_resumption(CLI::App* command);
inline constexpr const char* kResumption = "The same command resumes a stopped run.";

// Adds the flag -f, --force; `description` says what it replaces.
void add_force_flag(CLI::App* command, bool* force, const std::string& description);

// Accepts these words; the message of any other suggests the nearest.
CLI::Validator one_of(std::vector<std::string> words);

// An option or argument whose value is a configuration file: a path, or the name of one of
// Raywalk's own, which the help lists. The command finds the file with named_config()
// (shipped_configs.h), once all of the command line is known to be right.
CLI::Option* takes_config(CLI::Option* option, ConfigKind kind);

// Adds the flag -q, --quiet to the program and to all of its commands; `silence` is called, before
// any work, where it is given. Its argument tells whether standard output is silenced too: not
// where --json asks for it.
void add_quiet_flag(CLI::App* app, const std::function<void(bool)>& silence);

}  // namespace raywalk
