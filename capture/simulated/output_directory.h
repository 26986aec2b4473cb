// A directory that appears only when complete.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk::capture {

// Filled at path(), a hidden name beside the target; commit() gives it the target's name. Without
// commit() the destructor removes it, so a failure leaves nothing.
class OutputDirectory {
 public:
  // Throws UsageError for an empty target, Error if it exists, or its parent does not or is not
  // writable.
  explicit OutputDirectory(const std::filesystem::path& target);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  const std::filesystem::path& path() const { return partial_; }
  // Makes a directory in it and returns where. Throws Error.
  std::filesystem::path make(const std::string& name) const;
  // Throws Error, also where the target has come into being meanwhile.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

}  // namespace raywalk::capture
