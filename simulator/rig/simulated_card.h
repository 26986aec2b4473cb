// The memory card in the rig's camera: a directory with a capacity.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace raywalk::capture {

struct SimulatedCardFile {
  std::string name;  // "R0010001.JPG"
  std::int64_t bytes = 0;
};

// Thread-safe. Files already in the directory are kept, and numbering continues after them.
class SimulatedCard {
 public:
  // Creates the directory if missing. Throws Error if that fails.
  SimulatedCard(std::filesystem::path directory, std::int64_t capacity_bytes);

  // The next unused name: "R0010001.JPG", "R0010002.JPG", ... Each call returns a new one.
  std::string next_name();
  // Throws Error if the file cannot be written.
  void write(const std::string& name, const std::string& bytes);
  // Sorted by name, which is the order of creation.
  std::vector<SimulatedCardFile> files() const;
  bool has(const std::string& name) const;
  // Throws Error naming the file if it is not on the card.
  std::string read(const std::string& name) const;
  void erase(const std::string& name);

  std::int64_t capacity_bytes() const { return capacity_bytes_; }
  std::int64_t free_bytes() const;  // 0 or more

 private:
  std::filesystem::path directory_;
  std::int64_t capacity_bytes_;
  mutable std::mutex mutex_;
  std::map<std::string, std::int64_t> files_;
  std::int64_t used_bytes_ = 0;
  int last_number_ = 0;
};

}  // namespace raywalk::capture
