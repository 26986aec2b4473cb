// A file for intermediate values that is gone when the program ends, however it ends.
#pragma once

#include <filesystem>

namespace raywalk {

// An open file, empty, to read and write, whose name is removed at once.
class NamelessFile {
 public:
  // Throws Error naming the directory if no file can be made there.
  explicit NamelessFile(const std::filesystem::path& directory);
  ~NamelessFile();
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  int descriptor() const { return descriptor_; }

 private:
  int descriptor_ = -1;
};

}  // namespace raywalk
