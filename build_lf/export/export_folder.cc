#include "build_lf/export/export_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "export.json";
constexpr const char* kSignature = "\"raywalk-export\"";
constexpr std::size_t kSignedBytes = 400;
constexpr std::array kExtensions{".png", ".jpg", ".bin", ".txt", ".csv", ".json", ".ply"};
constexpr std::array kFolders{"images", "masks", "distances", "confidence", "sparse"};

bool is_part_of_export(const fs::path& relative, bool is_directory) {
  const std::string top = relative.begin()->string();
  const bool in_folder = std::find(kFolders.begin(), kFolders.end(), top) != kFolders.end();
  if (is_directory) return in_folder;
  const std::string extension = relative.extension().string();
  const bool known =
      std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
  return known && (in_folder || !relative.has_parent_path());
}

void require_free_folder(const fs::path& out, bool replace) {
  if (!replace) return require_absent(out, "--out");
  require_replaceable(out, {"an exported room", kMarker, kSignature, is_part_of_export});
}

}  // namespace

ExportFolder::ExportFolder(const fs::path& out, bool replace)
    : out_(without_trailing_slash(out)), replace_(replace) {
  require_free_folder(out_, replace_);
  make_directories(directory_of(out_));
  directory_ = temporary_beside(out_);
  make_directories(directory_);
}

ExportFolder::~ExportFolder() {
  if (completed_) return;
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

void ExportFolder::complete(const std::string& format, int stations) {
  write_file_atomically(
      directory_ / kMarker,
      fmt::format(
          "{{\n \"format\": {},\n \"format_version\": 1,\n \"kind\": \"{}\",\n \"stations\": "
          "{}\n}}\n",
          kSignature, format, stations));
  require_free_folder(out_, replace_);
  move_into_place(directory_, out_);
  completed_ = true;
}

void require_free_file(const fs::path& out, bool replace, const std::string& signature) {
  if (!replace) return require_absent(out, "--out");
  const fs::file_status status = fs::symlink_status(out);
  if (!fs::exists(status)) return;
  if (fs::is_regular_file(status) &&
      read_file_prefix(out, kSignedBytes).find(signature) != std::string::npos) {
    return;
  }
  throw Error("--force does not replace " + out.string() +
              ": it is not an export of Raywalk's; remove it yourself or choose another name");
}

}  // namespace raywalk::build_lf
