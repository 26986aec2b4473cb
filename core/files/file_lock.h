// An exclusive lock on a file, held by an open descriptor and so released by any end of the
// process: what one program is making, a second one does not touch.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

class FileLock {
 public:
  // Makes the file if need be and locks it. Throws Error: "cannot write <directory>: ..." if it
  // cannot be made, "<directory>: <busy>" if another lock holds it or its holder just took it away,
  // "cannot lock <file>: ..." if the file system locks no files.
  FileLock(const std::filesystem::path& file, const std::string& busy);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int fd_ = -1;
};

}  // namespace raywalk
