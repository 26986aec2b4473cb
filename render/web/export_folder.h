// The folder of an export while it is written: OUT.partial, which becomes OUT when it is complete.
#pragma once

#include <filesystem>

#include "core/files/file_lock.h"

namespace raywalk::render {

class ExportFolder {
 public:
  // Makes OUT.partial and locks it; what a killed run left there is removed. Throws Error if `out`
  // exists, unless `replace` is set and it is an earlier export with nothing else in it; if another
  // run writes to it; if OUT.partial holds anything else; if it cannot be written.
  ExportFolder(const std::filesystem::path& out, bool replace);
  // Removes what is there unless it was completed: an export is not resumed.
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Renames the folder to `out`, in place of an earlier export. Throws Error.
  void complete();

 private:
  std::filesystem::path out_;
  std::filesystem::path directory_;
  bool replace_;
  FileLock lock_;
  bool completed_ = false;
};

}  // namespace raywalk::render
