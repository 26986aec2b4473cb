// Raywalk's own configuration files, which need no path: they are known by name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace raywalk {

// The folder of this program's executable, beside which its other files are; empty where the system
// does not tell.
std::filesystem::path program_folder();

// What a file configures. The names of a kind's files are told apart by folder and by a part of the
// name: captures are all that have "capture" in it.
enum class ConfigKind { kCapture, kRig, kVirtualRoom, kView, kLens, kSlider, kScene };

// The folder of Raywalk's own files of a kind: share/raywalk/configs, or a folder in it, beside
// that of this program's executable. The build folder has it where an installation does.
std::filesystem::path shipped_configs(ConfigKind kind);

// Their names in alphabetical order, without ".yaml"; none if the folder is not there.
std::vector<std::string> shipped_config_names(ConfigKind kind);

// The file that `named` means: the path as it is written, relative to the folder `beside` (empty:
// the current one), if there is a file; else Raywalk's own of that name. "theta-like",
// "theta-like.yaml", "lenses/theta-like.yaml" and "configs/lenses/theta-like.yaml" are names of one
// lens file. If there is neither, the path as it is written; missing_config_text() says so.
std::filesystem::path config_path(const std::filesystem::path& named, ConfigKind kind,
                                  const std::filesystem::path& beside = {});

// The same for a command line. Throws UsageError naming `what` ("--lens-start") where there is
// neither a file nor a name; an empty path is left as it is.
std::filesystem::path named_config(const std::filesystem::path& named, ConfigKind kind,
                                   const std::string& what);

// The end of a message about a file that config_path() did not find, as "is '/rig/sliders/a.yaml'":
// that it is neither a file nor a name, with the names that may be meant; what a path is relative
// to and where Raywalk's own are.
std::string missing_config_text(const std::filesystem::path& file, ConfigKind kind);

}  // namespace raywalk
