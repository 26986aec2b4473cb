// The folder of an export: written under a temporary name beside it, renamed when it is complete.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk::build_lf {

class ExportFolder {
 public:
  // Makes the temporary folder. Throws Error if `out` exists, unless `replace` is set and it is an
  // earlier export with nothing else in it, or if it cannot be written.
  ExportFolder(const std::filesystem::path& out, bool replace);
  // Removes what is there unless it was completed: an export is not resumed. What a killed run
  // leaves, the next one beside it removes.
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Writes export.json, by which an export is known, and renames the folder to `out`, in place of
  // an earlier export. Throws Error.
  void complete(const std::string& format, int stations);

 private:
  std::filesystem::path out_;
  bool replace_;
  std::filesystem::path directory_;
  bool completed_ = false;
};

// Throws Error unless a file can be made at `out`: nothing is there, or, with `replace`, a file
// that begins with `signature`, within a few lines.
void require_free_file(const std::filesystem::path& out, bool replace,
                       const std::string& signature);

}  // namespace raywalk::build_lf
