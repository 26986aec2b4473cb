// For tests: what a depth run leaves in a room, to compare runs.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {

// Checksums of all files of a room but what tells of the run itself, which is in depth.html too.
inline std::map<std::string, std::string> result_files_of(const std::filesystem::path& room) {
  std::map<std::string, std::string> files = checksums_of_files(room);
  for (const std::string folder : {"", "held-out/"}) {
    const std::filesystem::path json = room / (folder + "depth.json");
    if (!std::filesystem::exists(json)) continue;
    auto document = nlohmann::json::parse(read_file(json));
    for (const char* key : {"room", "page", "seconds", "peak_memory_mb"}) document.erase(key);
    files[folder + "depth.json"] = document.dump();
    files.erase(folder + "depth.html");
  }
  return files;
}

}  // namespace raywalk::build_lf
