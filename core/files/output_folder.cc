#include "core/files/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

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

void rename_or_throw(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return;
  throw Error(
      fmt::format("cannot rename {} to {}: {}", from.string(), to.string(), error.message()));
}

// In one step where kernel and file system can, so that there is always a folder at `target`.
void exchange(const fs::path& directory, const fs::path& target) {
  if (::renameat2(AT_FDCWD, directory.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) {
    return;
  }
  const fs::path aside = directory.string() + ".replaced";
  rename_or_throw(target, aside);
  try {
    rename_or_throw(directory, target);
  } catch (const Error&) {
    rename_or_throw(aside, target);
    throw;
  }
  rename_or_throw(aside, directory);
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& out, bool replace, OwnOutput own)
    : out_(without_trailing_slash(out)), replace_(replace), own_(std::move(own)) {
  require_free(out_, replace_, own_);
  make_directories(directory_of(out_));
  directory_ = temporary_beside(out_);
  make_directories(directory_);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

void OutputFolder::complete() {
  require_free(out_, replace_, own_);
  move_into_place(directory_, out_);
}

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
    const bool is_folder = fs::is_directory(entry.symlink_status());
    if (!is_folder && !fs::is_regular_file(entry.symlink_status())) {
      refuse(path, "it holds " + relative.string() + ", which Raywalk did not write");
    }
    if (!own.belongs(relative, is_folder)) {
      refuse(path, "it holds " + relative.string() + ", which is not part of " + own.what);
    }
  }
}

void require_free(const fs::path& out, bool replace, const OwnOutput& own) {
  if (replace) {
    require_replaceable(out, own);
  } else {
    require_absent(out, "--out");
  }
}

void require_replaceable_file(const fs::path& file, const std::string& what,
                              const std::string& signature) {
  if (fs::exists(fs::symlink_status(file)) && !is_signed(file, signature)) {
    refuse(file, "it is not " + what + " of Raywalk's");
  }
}

void move_into_place(const fs::path& directory, const fs::path& target) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(target, error))) {
    rename_or_throw(directory, target);
    return;
  }
  exchange(directory, target);
  fs::remove_all(directory, error);
  if (!error) return;
  spdlog::warn("{}: what was replaced is still there: {}", directory.string(), error.message());
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

}  // namespace raywalk
