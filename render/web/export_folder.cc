#include "render/web/export_folder.h"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "render/web/web_manifest.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockName = "lock";
constexpr std::array<std::string_view, 2> kFolders{"stations", "truth"};
// Of the page's files and of those of the stations and truths.
constexpr std::array<std::string_view, 5> kPageExtensions{".html", ".js", ".css", ".map", ".txt"};
constexpr std::array<std::string_view, 2> kDataExtensions{".jpg", ".omega"};

template <std::size_t kCount>
bool is_one_of(const std::string& name, const std::array<std::string_view, kCount>& names) {
  for (const std::string_view one : names) {
    if (name == one) return true;
  }
  return false;
}

bool is_part_of_export(const fs::path& relative, bool is_directory) {
  const std::string name = relative.filename().string();
  const std::string parent = relative.parent_path().string();
  if (is_directory) return parent.empty() && is_one_of(name, kFolders);
  const std::string extension = relative.extension().string();
  if (name.front() == '.') return true;  // a temporary file of a killed run
  if (!parent.empty()) return is_one_of(parent, kFolders) && is_one_of(extension, kDataExtensions);
  return name == kManifestName || name == kLockName || is_one_of(extension, kPageExtensions);
}

// Throws Error unless the directory is absent or holds only what a killed run left: it is known by
// its lock file, which is written first.
void require_leftovers_only(const fs::path& directory) {
  const fs::file_status status = fs::symlink_status(directory);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status)) {
    throw Error(directory.string() + " is in the way; remove it or choose another --out");
  }
  const bool is_locked = fs::exists(directory / kLockName);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(directory)) {
    const fs::path relative = entry.path().lexically_relative(directory);
    if (is_locked && is_part_of_export(relative, fs::is_directory(entry.symlink_status())))
      continue;
    throw Error(
        fmt::format("{} holds {}, which is not of an unfinished export; remove it or choose "
                    "another --out",
                    directory.string(), relative.string()));
  }
}

void require_free(const fs::path& out, bool replace) {
  if (!replace) {
    require_absent(out, "--out");
    return;
  }
  require_replaceable(out, {"an exported room", kManifestName, fmt::format("\"{}\"", kWebFormat),
                            is_part_of_export});
}

fs::path made_directory(const fs::path& directory) {
  require_leftovers_only(directory);
  make_directories(directory);
  return directory;
}

}  // namespace

ExportFolder::ExportFolder(const fs::path& out, bool replace)
    : out_(without_trailing_slash(out)),
      directory_((require_free(out_, replace), made_directory(out_.string() + ".partial"))),
      replace_(replace),
      lock_(directory_ / kLockName, "another run is writing this export; wait for it to finish") {
  for (const std::string_view folder : kFolders) fs::remove_all(directory_ / folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_)) {
    if (entry.path().filename() != kLockName) fs::remove(entry.path());
  }
  make_directories(directory_ / "stations");
}

ExportFolder::~ExportFolder() {
  if (completed_) return;
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

void ExportFolder::complete() {
  require_free(out_, replace_);
  fs::remove(directory_ / kLockName);
  move_into_place(directory_, out_);
  completed_ = true;
}

}  // namespace raywalk::render
