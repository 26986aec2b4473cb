// The working directory `<out>.partial` of a pack run, renamed to `out` when complete. A stopped
// run leaves its finished volumes there, to be resumed. Runs that pack some of the lines each share
// it.
#pragma once

#include <filesystem>
#include <string>

#include "core/files/file_lock.h"

namespace raywalk::build_lf {

// Throws Error, with the reason, unless --force may replace `out`: it is absent, empty, or a room
// with nothing else in it.
void require_replaceable_room(const std::filesystem::path& out);

// Throws Error unless a room can be made at `out`: nothing is there, or, with `replace`, a room
// that may be replaced.
void require_free(const std::filesystem::path& out, bool replace);

// What refine keeps of a room that it makes until its lines are written: a file for each station.
inline constexpr const char* kDevelopedDirectory = "stations";
inline constexpr const char* kDevelopedExtension = ".developed";

class PartialRoom {
 public:
  // Creates or reuses the directory, locks it and removes the volumes that a killed run left
  // unfinished. Throws Error if `out` exists, another run holds
  // the lock, the directory holds volumes of other inputs (another fingerprint), or it cannot be
  // written. With `replace`, a room at `out` is replaced by complete() (Error if anything else is
  // there), and volumes of other inputs are removed.
  // Shared, the directory is prepared and cleared of volumes of other inputs by whoever has it
  // alone; only its owner's unfinished volumes, and those of processes that are certainly gone, are
  // removed.
  PartialRoom(const std::filesystem::path& out, const std::string& fingerprint,
              bool replace = false, FileLock::Use use = FileLock::Use::kAlone);
  // Removes the directory unless it holds a finished volume, was completed, or others share it.
  ~PartialRoom();
  PartialRoom(const PartialRoom&) = delete;
  PartialRoom& operator=(const PartialRoom&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Removes everything, including finished volumes, unless others share the directory.
  void discard();
  // Renames the directory to `out`, in place of what complete() may replace. Throws Error on
  // failure.
  void complete();

 private:
  // Acquires the directory and the lock. A delegated constructor, so that the destructor releases
  // them if the rest of the construction throws.
  PartialRoom(bool replace, const std::filesystem::path& out, FileLock::Use use);
  // By the one who has the directory alone: removes what is unfinished or, if it may, of other
  // inputs.
  void prepare(const std::string& fingerprint);
  bool is_of(const std::string& fingerprint) const;
  [[noreturn]] void throw_other_inputs() const;

  std::filesystem::path out_;
  std::filesystem::path directory_;
  bool replace_;
  FileLock lock_;
  bool completed_ = false;
};

}  // namespace raywalk::build_lf
