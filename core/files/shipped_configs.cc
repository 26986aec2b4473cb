#include "core/files/shipped_configs.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "core/files/output_folder.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".yaml";

struct KindPlace {
  const char* folder;   // in configs; empty: configs itself
  const char* in_name;  // what names of this kind contain
};

KindPlace place_of(ConfigKind kind) {
  constexpr KindPlace kPlaces[] = {{"", "capture"}, {"", "rig"},     {"", "virtual-"}, {"", "view"},
                                   {"lenses", ""},  {"sliders", ""}, {"scenes", ""}};
  return kPlaces[static_cast<std::size_t>(kind)];
}

// Anything that can be read: a named pipe too.
bool is_file(const fs::path& path) {
  std::error_code none;
  return fs::exists(path, none) && !fs::is_directory(path, none);
}

std::string name_of(const fs::path& file) {
  return (file.extension() == kExtension ? file.stem() : file.filename()).string();
}

}  // namespace

fs::path program_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path shipped_configs(ConfigKind kind) {
  const fs::path configs = program_folder() / ".." / "share" / "raywalk" / "configs";
  return without_trailing_slash((configs / place_of(kind).folder).lexically_normal());
}

std::vector<std::string> shipped_config_names(ConfigKind kind) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(shipped_configs(kind), error)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() == kExtension &&
        name.find(place_of(kind).in_name) != std::string::npos) {
      names.push_back(name);
    }
  }
  std::ranges::sort(names);
  return names;
}

fs::path config_path(const fs::path& named, ConfigKind kind, const fs::path& beside) {
  fs::path as_written = beside / named;
  if (is_file(as_written)) return as_written;
  const fs::path folder = place_of(kind).folder;
  const fs::path above = named.parent_path();
  const bool is_name =
      above.empty() || above == folder || above == without_trailing_slash("configs" / folder);
  const std::vector<std::string> names = shipped_config_names(kind);
  if (!is_name || std::ranges::find(names, name_of(named)) == names.end()) return as_written;
  return shipped_configs(kind) / (name_of(named) + kExtension);
}

fs::path named_config(const fs::path& named, ConfigKind kind, const std::string& what) {
  if (named.empty()) return named;
  fs::path file = config_path(named, kind);
  if (!is_file(file)) throw UsageError(what + " " + missing_config_text(file, kind));
  return file;
}

std::string missing_config_text(const fs::path& file, ConfigKind kind) {
  return fmt::format(
      "is '{}', which is not a file, and '{}' is no name of Raywalk's own in {}{} (a path in a "
      "configuration file is relative to that file, one on the command line to the current folder)",
      fs::absolute(file).lexically_normal().string(), name_of(file), shipped_configs(kind).string(),
      suggestion(name_of(file), shipped_config_names(kind)));
}

}  // namespace raywalk
