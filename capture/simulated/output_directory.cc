#include "capture/simulated/output_directory.h"

#include <fmt/format.h>

#include <set>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_cannot_create(const fs::path& target, const std::error_code& error) {
  throw Error(fmt::format("cannot create {}: {}", target.string(), error.message()));
}

// Tells the capture of a virtual room from photographs in folders of the same names.
constexpr const char* kMarker = "virtual-room.json";
constexpr const char* kSignature = "raywalk-virtual-room";

bool is_part_of_capture(const fs::path& relative, bool is_directory) {
  static const std::set<std::string> directories{"capture", "dist", "gt"};
  static const std::set<std::string> files{kMarker, "poses.csv", "true_poses.csv", "gt.csv"};
  const bool at_top = !relative.has_parent_path();
  if (is_directory) return at_top && directories.count(relative.string()) > 0;
  if (at_top) return files.count(relative.string()) > 0;
  return relative.extension() == ".png" || relative.extension() == ".jpg";
}

void require_free(const fs::path& target, bool replace) {
  if (target.empty()) throw UsageError("the output directory has no name; choose one with --out");
  if (replace) {
    require_replaceable(target,
                        {"a virtual room's capture", kMarker, kSignature, is_part_of_capture});
  } else {
    require_absent(target, "--out");
  }
}

fs::path create_beside(const fs::path& target) {
  fs::path partial = temporary_beside(target);
  std::error_code error;
  fs::create_directory(partial, error);
  if (error) throw_cannot_create(target, error);
  return partial;
}

}  // namespace

OutputDirectory::OutputDirectory(const fs::path& target, bool replace)
    : target_(without_trailing_slash(target)),
      replace_(replace),
      partial_((require_free(target_, replace), create_beside(target_))) {}

OutputDirectory::~OutputDirectory() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
}

fs::path OutputDirectory::make(const std::string& name) const {
  std::error_code error;
  fs::create_directory(partial_ / name, error);
  if (error) throw_cannot_create(target_ / name, error);
  return partial_ / name;
}

void OutputDirectory::mark() const {
  write_file_atomically(partial_ / kMarker, fmt::format("{{\"format\": \"{}\"}}\n", kSignature));
}

void OutputDirectory::commit() {
  require_free(target_, replace_);
  move_into_place(partial_, target_);
  committed_ = true;
}

}  // namespace raywalk::capture
