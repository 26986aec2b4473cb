// For tests: all files of a folder, to compare the results of two runs.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/sha256.h"

namespace raywalk {

// The checksum of every file below a folder, by its path from there.
inline std::map<std::string, std::string> checksums_of_files(const std::filesystem::path& folder) {
  std::map<std::string, std::string> checksums;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    checksums.emplace(entry.path().lexically_relative(folder).string(),
                      sha256_hex(read_file(entry.path())));
  }
  return checksums;
}

}  // namespace raywalk
