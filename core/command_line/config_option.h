// Options and arguments whose value is a configuration file: a path, or the name of one of
// Raywalk's own.
#pragma once

#include <optional>
#include <string>

#include "core/files/shipped_configs.h"

namespace CLI {
class Option;
}

namespace raywalk {

// Names the kind in the help, and thereby in the completion of shells. The command finds the file
// with named_config() (shipped_configs.h), once all of the command line is known to be right.
CLI::Option* takes_config(CLI::Option* option, ConfigKind kind);

// The kind that the option's type name in a help text stands for; none for other options.
std::optional<ConfigKind> config_kind_of(const std::string& type_name);

}  // namespace raywalk
