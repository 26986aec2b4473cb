#include "core/files/directory_moves.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>

#include <cerrno>
#include <system_error>

#include "core/base/error.h"

namespace raywalk {

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
  if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return true;
  const std::error_code error(errno, std::generic_category());
  if (error == std::errc::invalid_argument || error == std::errc::function_not_supported) {
    return false;
  }
  throw Error(
      fmt::format("cannot exchange {} and {}: {}", a.string(), b.string(), error.message()));
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

}  // namespace raywalk
