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

// Makes the option's value, as parsed, the path that config_path() (shipped_configs.h) finds for
// what is given, and names the kind in the help. A value that is neither a file nor a name is
// refused with UsageError while the command line is parsed; an empty one is left as it is.
CLI::Option* takes_config(CLI::Option* option, ConfigKind kind);

// The kind that the option's type name in a help text stands for; none for other options.
std::optional<ConfigKind> config_kind_of(const std::string& type_name);

}  // namespace raywalk
