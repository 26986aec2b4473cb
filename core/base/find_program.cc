#include "core/base/find_program.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <system_error>

namespace raywalk {
namespace {

bool is_executable(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (!folder.empty() && is_executable(file)) return std::filesystem::absolute(file);
  }
  return std::nullopt;
}

}  // namespace raywalk
