#include "core/files/shipped_configs.h"

#include <fmt/format.h>

#include <system_error>

#include "core/files/program_folder.h"

namespace raywalk {

namespace fs = std::filesystem;

fs::path shipped_configs(const std::string& folder) {
  fs::path wanted = folder.empty() ? fs::path("configs") : fs::path("configs") / folder;
  fs::path above = program_folder();
  while (!above.empty()) {
    std::error_code none;
    if (fs::is_directory(above / wanted, none)) return above / wanted;
    if (above == above.parent_path()) break;
    above = above.parent_path();
  }
  return wanted;
}

std::string missing_config_text(const fs::path& file, const std::string& folder) {
  return fmt::format(
      "is '{}', which is not a file; a path in a configuration file is relative to that file, one "
      "on the command line to the current folder; Raywalk's own are in {}: name one of them by its "
      "whole path, or copy that folder there",
      fs::absolute(file).lexically_normal().string(), shipped_configs(folder).string());
}

}  // namespace raywalk
