#include "core/files/output_path.h"

#include <spdlog/spdlog.h>

#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/directory_moves.h"

namespace raywalk {

namespace fs = std::filesystem;

namespace {

// The part of a marker that is searched for its signature.
constexpr std::size_t kSignedBytes = 400;

[[noreturn]] void refuse(const fs::path& path, const std::string& reason) {
  throw Error("--force does not replace " + path.string() + ": " + reason +
              "; remove it yourself or choose another name");
}

bool is_signed(const fs::path& marker, const std::string& signature) {
  if (!fs::is_regular_file(fs::symlink_status(marker))) return false;
  return read_file_prefix(marker, kSignedBytes).find(signature) != std::string::npos;
}

// For file systems that cannot exchange two names: `target` is missing for a moment.
void exchange_in_steps(const fs::path& directory, const fs::path& target) {
  const fs::path aside = directory.string() + ".replaced";
  fs::rename(target, aside);
  std::error_code error;
  fs::rename(directory, target, error);
  if (error) {
    fs::rename(aside, target);
    throw fs::filesystem_error("", target, error);
  }
  fs::rename(aside, directory);
}

void remove_replaced(const fs::path& directory) {
  std::error_code error;
  fs::remove_all(directory, error);
  if (error)
    spdlog::warn("{}: what was replaced is still there: {}", directory.string(), error.message());
}

}  // namespace

fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

void require_absent(const fs::path& path, const std::string& option) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(path, ignored))) {
    throw Error(path.string() + ": exists already; choose another " + option +
                ", or replace it with --force");
  }
}

void require_replaceable(const fs::path& path, const OwnOutput& own) {
  const fs::file_status status = fs::symlink_status(path);
  if (!fs::exists(status)) return;
  if (fs::is_symlink(status)) refuse(path, "it is a symbolic link");
  if (!fs::is_directory(status)) refuse(path, "it is a file, not " + own.what);
  if (fs::is_empty(path)) return;
  if (!is_signed(path / own.marker, own.signature)) {
    refuse(path, "it is not " + own.what + " made by Raywalk, as it holds no " + own.marker +
                     " that Raywalk wrote");
  }
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
    const fs::path relative = entry.path().lexically_relative(path);
    const bool directory = fs::is_directory(entry.symlink_status());
    if (!directory && !fs::is_regular_file(entry.symlink_status())) {
      refuse(path, "it holds " + relative.string() + ", which Raywalk did not write");
    }
    if (!own.belongs(relative, directory)) {
      refuse(path, "it holds " + relative.string() + ", which is not part of " + own.what);
    }
  }
}

void move_into_place(const fs::path& directory, const fs::path& target) {
  std::error_code unknown;
  if (!fs::exists(fs::symlink_status(target, unknown))) {
    rename_or_throw(directory, target);
    return;
  }
  if (!exchange(directory, target)) exchange_in_steps(directory, target);
  remove_replaced(directory);
}

}  // namespace raywalk
