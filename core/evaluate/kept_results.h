// What a long run has finished so far, kept in one file, so that a run that was stopped is resumed
// by the same command. Each result stands under a key made of everything it depends on: what was
// made of other inputs is never found.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace raywalk {

class KeptResults {
 public:
  // Reads what an earlier run left in the file. What is damaged counts as missing, with a warning.
  // Throws Error where the file cannot be written.
  explicit KeptResults(std::filesystem::path file);

  // The result under a key; where there is none, it is made, added and the file written,
  // atomically. Numbers that are not finite are null. Throws Error where it cannot be written, and
  // as `make`.
  nlohmann::ordered_json get(const std::string& key,
                             const std::function<nlohmann::ordered_json()>& make);
  // The results under keys; make(i) makes that of keys[i]. Prints progress, of so many `unit`s of
  // `what`. Throws as get(); Interrupted.
  std::vector<nlohmann::ordered_json> get_all(
      std::span<const std::string> keys, const std::string& what, const std::string& unit,
      const std::function<nlohmann::ordered_json(std::size_t)>& make);
  // Removes the file: the run is complete.
  void remove();

 private:
  std::filesystem::path file_;
  nlohmann::ordered_json results_ = nlohmann::ordered_json::object();
};

}  // namespace raywalk
