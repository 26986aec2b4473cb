// Where Raywalk's own configuration files are, for messages.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

// Raywalk's configs/<folder> ("sliders", "lenses"; empty: configs itself): the one beside or above
// this program's executable, or, if there is none, "configs/<folder>" as the sources name it.
std::filesystem::path shipped_configs(const std::string& folder);

// The end of a message about a file that is named but not there, as "is '/rig/sliders/a.yaml'":
// that it is not a file, what its path is relative to, where Raywalk's own of `folder` are and what
// to do.
std::string missing_config_text(const std::filesystem::path& file, const std::string& folder);

}  // namespace raywalk
