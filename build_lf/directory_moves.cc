#include "build_lf/directory_moves.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>

#include <system_error>

#include "core/base/error.h"

namespace raywalk::build_lf {

namespace fs = std::filesystem;

void rename_or_throw(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    throw Error(
        fmt::format("cannot rename {} to {}: {}", from.string(), to.string(), error.message()));
  }
}

bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

void copy_by_links(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::remove_all(to, error);
  fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::create_hard_links, error);
  if (!error) return;
  fs::remove_all(to, error);
  fs::copy(from, to, fs::copy_options::recursive, error);
  if (error) {
    throw Error(
        fmt::format("cannot copy {} to {}: {}", from.string(), to.string(), error.message()));
  }
}

}  // namespace raywalk::build_lf
