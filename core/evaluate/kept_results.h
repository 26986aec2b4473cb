// What a long run has finished so far, kept in one file, so that a run that was stopped is resumed
// by the same command. Each result stands under a key made of everything it depends on: what was
// made of other inputs is never found.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace raywalk {

class KeptResults {
 public:
  // Reads what an earlier run left in the file. What is damaged counts as missing, with a warning.
  // Throws Error where the file cannot be written.
  explicit KeptResults(std::filesystem::path file);

  // Null where there is none. Numbers that are not finite are null.
  const nlohmann::ordered_json* find(const std::string& key) const;
  // Adds a result and writes the file, atomically. Throws Error where it cannot be written.
  void keep(const std::string& key, const nlohmann::ordered_json& result);
  // Removes the file: the run is complete.
  void remove();

 private:
  std::filesystem::path file_;
  nlohmann::ordered_json results_ = nlohmann::ordered_json::object();
};

}  // namespace raywalk
