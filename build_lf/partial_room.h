// The working directory `<out>.partial` of a pack run, renamed to `out` when complete. A stopped
// run leaves its finished volumes there, to be resumed.
#pragma once

#include <filesystem>
#include <string>

#include "core/files/file_lock.h"

namespace raywalk::build_lf {

class PartialRoom {
 public:
  // Creates or reuses the directory, locks it and removes the volumes that a killed run left
  // unfinished. Throws Error if `out` exists, another run holds
  // the lock, the directory holds volumes of other inputs (another fingerprint), or it cannot be
  // written.
  PartialRoom(const std::filesystem::path& out, const std::string& fingerprint);
  // Removes the directory unless it holds a finished volume or was completed.
  ~PartialRoom();
  PartialRoom(const PartialRoom&) = delete;
  PartialRoom& operator=(const PartialRoom&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Removes everything, including finished volumes.
  void discard();
  // Renames the directory to `out`. Throws Error on failure.
  void complete();

 private:
  // Acquires the directory and the lock. A delegated constructor, so that the destructor releases
  // them if the rest of the construction throws.
  explicit PartialRoom(const std::filesystem::path& out);
  bool has_finished_volume() const;

  std::filesystem::path out_;
  std::filesystem::path directory_;
  FileLock lock_;
  bool completed_ = false;
};

}  // namespace raywalk::build_lf
