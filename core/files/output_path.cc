#include "core/files/output_path.h"

#include <system_error>

#include "core/base/error.h"

namespace raywalk {

namespace fs = std::filesystem;

fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

void require_absent(const fs::path& path, const std::string& option) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(path, ignored))) {
    throw Error(path.string() + ": exists already; remove it or choose another " + option);
  }
}

}  // namespace raywalk
