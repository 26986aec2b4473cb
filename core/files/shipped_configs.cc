#include "core/files/shipped_configs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <optional>
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
  constexpr KindPlace kPlaces[] = {{"", "capture"}, {"", "rig"},    {"", "virtual-"},
                                   {"", "view"},    {"lenses", ""}, {"sliders", ""}};
  return kPlaces[static_cast<std::size_t>(kind)];
}

// Anything that can be read: a named pipe too.
bool is_file(const fs::path& path) {
  std::error_code none;
  return fs::exists(path, none) && !fs::is_directory(path, none);
}

// "theta-like" of "configs/lenses/theta-like.yaml"; none if it is a path into another folder.
std::optional<std::string> name_in(const fs::path& named, const char* folder) {
  const fs::path above = named.parent_path();
  const fs::path in_configs = without_trailing_slash(fs::path("configs") / folder);
  if (!above.empty() && above != fs::path(folder) && above != in_configs) return std::nullopt;
  return (named.extension() == kExtension ? named.stem() : named.filename()).string();
}

// "; did you mean ...": all names that begin so, else as suggestion() (words.h).
std::string meant_names(const std::string& word, const std::vector<std::string>& names) {
  if (names.empty()) return "";
  std::vector<std::string> begun;
  std::copy_if(names.begin(), names.end(), std::back_inserter(begun),
               [&](const std::string& name) { return !word.empty() && name.starts_with(word); });
  if (begun.size() < 2) return suggestion(word, names);
  return fmt::format("; did you mean one of '{}'?", fmt::join(begun, "', '"));
}

}  // namespace

fs::path program_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path shipped_configs(ConfigKind kind) {
  fs::path configs = (program_folder() / ".." / "share" / "raywalk" / "configs").lexically_normal();
  const char* folder = place_of(kind).folder;
  return *folder == '\0' ? configs : configs / folder;
}

std::vector<std::string> shipped_config_names(ConfigKind kind) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(shipped_configs(kind), error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().stem().string();
    if (entry->path().extension() == kExtension &&
        name.find(place_of(kind).in_name) != std::string::npos) {
      names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path config_path(const fs::path& named, ConfigKind kind, const fs::path& beside) {
  fs::path as_written = beside / named;
  if (is_file(as_written)) return as_written;
  const std::optional<std::string> name = name_in(named, place_of(kind).folder);
  const std::vector<std::string> names = shipped_config_names(kind);
  if (!name || std::find(names.begin(), names.end(), *name) == names.end()) return as_written;
  return shipped_configs(kind) / (*name + kExtension);
}

fs::path named_config(const fs::path& named, ConfigKind kind, const std::string& what) {
  if (named.empty()) return named;
  fs::path file = config_path(named, kind);
  std::error_code none;
  if (!fs::exists(file, none) || fs::is_directory(file, none)) {
    throw UsageError(what + " " + missing_config_text(file, kind));
  }
  return file;
}

std::string missing_config_text(const fs::path& file, ConfigKind kind) {
  const std::string word =
      (file.extension() == kExtension ? file.stem() : file.filename()).string();
  return fmt::format(
      "is '{}', which is not a file, and '{}' is no name of Raywalk's own in {}{} (a path in a "
      "configuration file is relative to that file, one on the command line to the current folder)",
      fs::absolute(file).lexically_normal().string(), word, shipped_configs(kind).string(),
      meant_names(word, shipped_config_names(kind)));
}

}  // namespace raywalk
