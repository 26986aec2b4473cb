// An output directory that appears under its name only when complete.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk::capture {

// Files are written to path(), a hidden directory beside the target; commit() renames it to the
// target, in place of an earlier capture if that is to be replaced. Without commit() the destructor
// removes it.
class OutputDirectory {
 public:
  // Throws UsageError if the target is empty, Error if it exists (with `replace`: if it is not the
  // capture of a virtual room) or its parent is missing or not writable.
  explicit OutputDirectory(const std::filesystem::path& target, bool replace = false);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  const std::filesystem::path& path() const { return partial_; }
  // Creates a subdirectory and returns its path. Throws Error if that fails.
  std::filesystem::path make(const std::string& name) const;
  // Marks the directory as the capture of a virtual room, which `replace` may replace. Throws
  // Error.
  void mark() const;
  // Throws Error if renaming fails or the target has been created in the meantime.
  void commit();

 private:
  std::filesystem::path target_;
  bool replace_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

}  // namespace raywalk::capture
