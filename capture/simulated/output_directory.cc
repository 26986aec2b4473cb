#include "capture/simulated/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "core/base/error.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// "capture/" and "capture" are the same directory, but only the latter has a name to extend.
fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

void require_absent(const fs::path& target) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(target, ignored))) {
    throw Error(target.string() + ": exists already; remove it or choose another --out");
  }
}

void make_directory(const fs::path& directory, const fs::path& target) {
  std::error_code error;
  fs::create_directory(directory, error);
  if (error) throw Error(fmt::format("cannot make {}: {}", target.string(), error.message()));
}

}  // namespace

OutputDirectory::OutputDirectory(const fs::path& target)
    : target_(without_trailing_slash(target)),
      partial_(target_.parent_path() /
               fmt::format(".{}.{}.partial", target_.filename().string(), getpid())) {
  require_absent(target_);
  make_directory(partial_, target_);
}

OutputDirectory::~OutputDirectory() {
  std::error_code ignored;
  if (!committed_) fs::remove_all(partial_, ignored);
}

fs::path OutputDirectory::make(const std::string& name) const {
  make_directory(partial_ / name, target_ / name);
  return partial_ / name;
}

void OutputDirectory::commit() {
  require_absent(target_);
  std::error_code error;
  fs::rename(partial_, target_, error);
  if (error) throw Error(fmt::format("cannot make {}: {}", target_.string(), error.message()));
  committed_ = true;
}

}  // namespace raywalk
