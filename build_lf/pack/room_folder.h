// The folder `<out>.partial` in which a room is made, renamed to `out` when it is complete.
//
// Each volume says what it was made from (inputs_of). So one comparison tells whether it is that of
// a stopped run, of a run that shares the folder, or of the room that is replaced, and is kept, or
// of other inputs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/files/file_lock.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Throws Error, with the reason, unless --force may replace `out`: it is absent, empty, or a room
// with nothing else in it.
void require_replaceable_room(const std::filesystem::path& out);

// Throws Error unless a room can be made at `out`: nothing is there, or, with `replace`, a room
// that may be replaced.
void require_free(const std::filesystem::path& out, bool replace);

// What refine keeps of a room that it makes until its lines are written: a volume for each station.
inline constexpr const char* kDevelopedDirectory = "stations";

// A volume of a room that is made.
struct PlannedVolume {
  std::filesystem::path file{};  // relative to the room
  std::string inputs{};          // SHA-256 over everything that determines its bytes
};

class RoomFolder {
 public:
  // Makes or reuses the folder, locks it and removes what a killed run left unfinished. Throws
  // Error if `out` is in the way, another run holds the lock, the folder holds volumes that are not
  // as planned, or it cannot be written. With `replace`, a room at `out` is replaced by complete(),
  // and volumes that are not as planned are removed.
  // Shared, only who has the folder alone for the moment removes anything.
  RoomFolder(const std::filesystem::path& out, const std::vector<PlannedVolume>& volumes,
             bool replace = false, FileLock::Use use = FileLock::Use::kAlone);
  // Removes the folder unless it holds a finished volume, was completed, or others share it.
  ~RoomFolder();
  RoomFolder(const RoomFolder&) = delete;
  RoomFolder& operator=(const RoomFolder&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  bool has(const std::filesystem::path& file) const;
  // Puts a volume there if the room that is replaced has it: by a hard link, or a copy on file
  // systems without them. Returns whether it has. Throws Error, Interrupted.
  bool take_over(const PlannedVolume& volume) const;
  // Writes the manifest and renames the folder to `out`, in place of what may be replaced. Throws
  // Error on failure, also if the result cannot be opened.
  void complete(const RoomManifest& manifest);

 private:
  std::vector<std::filesystem::path> volumes_not_in(const std::vector<PlannedVolume>& plan) const;
  void remove_empty_folders() const;

  std::filesystem::path out_;
  bool replace_;
  std::filesystem::path directory_;
  FileLock lock_;
  bool completed_ = false;
};

}  // namespace raywalk::build_lf
