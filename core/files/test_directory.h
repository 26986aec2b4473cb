// For tests: a temporary directory, removed by the destructor, and what a folder holds.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "core/files/fingerprint.h"

namespace raywalk {

class TestDirectory {
 public:
  TestDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "raywalk_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
    path_ = name;
  }
  ~TestDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TestDirectory(const TestDirectory&) = delete;
  TestDirectory& operator=(const TestDirectory&) = delete;

  std::filesystem::path path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  // The number of entries, to check that nothing is left behind.
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

// The checksum of every file below a folder, by its path from there, to compare two runs.
inline std::map<std::string, std::string> checksums_of_files(const std::filesystem::path& folder) {
  std::map<std::string, std::string> checksums;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    checksums.emplace(entry.path().lexically_relative(folder).string(),
                      sha256_of_file(entry.path()));
  }
  return checksums;
}

}  // namespace raywalk
