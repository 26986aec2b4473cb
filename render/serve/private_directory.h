// A directory for files that only this process needs.
#pragma once

#include <filesystem>

namespace raywalk::render {

// In the system's directory for temporary files ($TMPDIR, else /tmp), readable by this user alone;
// removed with everything in it by the destructor.
class PrivateDirectory {
 public:
  // Throws Error where it cannot be made.
  PrivateDirectory();
  ~PrivateDirectory();
  PrivateDirectory(const PrivateDirectory&) = delete;
  PrivateDirectory& operator=(const PrivateDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace raywalk::render
