// The files that a list names.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

namespace raywalk {

// Lists travel between systems: Windows writes '\', some file systems keep neither the case of
// names nor the form of their accents (macOS decomposes them, Unicode's NFD).
class ListedFiles {
 public:
  // Of a list whose names are relative to `folder`; "" is the current directory.
  explicit ListedFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // The path of the file meant by `name`: as written if it is there; else with '/' for '\', and
  // else, folder by folder, the one entry that differs in nothing but case and Unicode form. As
  // written if there is none, or more than one.
  std::filesystem::path find(const std::string& name);

 private:
  using Entries = std::unordered_map<std::string, std::filesystem::path>;
  // By their names in lower case and one form; empty where two have the same.
  const Entries& entries_of(const std::filesystem::path& folder);

  std::filesystem::path folder_;
  std::map<std::filesystem::path, Entries> seen_{};
};

}  // namespace raywalk
