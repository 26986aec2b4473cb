// The directory `<out>.partial` in which a room is made, until it is complete and takes its final
// name. A run that was stopped leaves its finished volumes there for the next one.
#pragma once

#include <filesystem>
#include <string>

#include "core/files/file_lock.h"

namespace raywalk::build_lf {

class PartialRoom {
 public:
  // Makes or takes over the directory and locks it. Throws Error: `out` exists, another run is at
  // work, the directory holds volumes of other inputs (another fingerprint), or cannot be written.
  PartialRoom(const std::filesystem::path& out, const std::string& fingerprint);
  // Removes the directory unless it holds a finished volume or was completed.
  ~PartialRoom();
  PartialRoom(const PartialRoom&) = delete;
  PartialRoom& operator=(const PartialRoom&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Removes all, finished volumes too.
  void discard();
  // Renames the directory to `out`. Throws Error.
  void complete();

 private:
  // The first half of construction: what it acquires, the destructor releases even if the rest
  // throws.
  explicit PartialRoom(const std::filesystem::path& out);
  bool has_finished_volume() const;

  std::filesystem::path out_;
  std::filesystem::path directory_;
  FileLock lock_;
  bool completed_ = false;
};

}  // namespace raywalk::build_lf
