#include "build_lf/partial_room.h"

#include <fmt/format.h>

#include <array>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/block_counts.h"
#include "core/files/output_path.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";
constexpr const char* kFingerprintFile = "inputs.sha256";
constexpr const char* kBlocksDirectory = "blocks";
constexpr std::array kVolumeDirectories = {"lines", "distances/given", "distances/estimated",
                                           kDevelopedDirectory};

fs::path made_directory(const fs::path& directory) {
  std::error_code error;
  fs::create_directory(directory, error);
  if (error) throw Error(fmt::format("cannot make {}: {}", directory.string(), error.message()));
  return directory;
}

fs::path partial_path(const fs::path& out) { return out.string() + ".partial"; }

// Everything that Raywalk writes into a room: volumes and what was measured on it.
bool is_part_of_room(const fs::path& relative, bool is_directory) {
  const std::string name = relative.filename().string();
  if (is_directory) {
    return name == "lines" || name.starts_with("distances") || name == "given" ||
           name == "estimated" || name == "held-out";
  }
  const std::string extension = relative.extension().string();
  return name.front() == '.' || name == "lock" || extension == ".h5" || extension == ".json" ||
         extension == ".html" || extension == ".log" || extension == ".sha256";
}

// Temporary files of a killed run start with a dot.
bool is_finished_volume(const fs::path& file) {
  const bool known = file.extension() == ".h5" || file.extension() == kDevelopedExtension;
  return known && file.filename().string().front() != '.';
}

// For the holder of the lock, who knows that no other run writes them.
void remove_unfinished_volumes(const fs::path& room) {
  std::error_code missing;
  for (const char* name : kVolumeDirectories) {
    for (const fs::directory_entry& entry : fs::directory_iterator(room / name, missing)) {
      if (!is_finished_volume(entry.path())) fs::remove(entry.path());
    }
  }
}

}  // namespace

void require_replaceable_room(const fs::path& out) {
  require_replaceable(out, {"a room", "manifest.json", "\"raywalk-room\"", is_part_of_room});
}

void require_free(const fs::path& out, bool replace) {
  if (replace) {
    require_replaceable_room(out);
  } else {
    require_absent(out, "--out");
  }
}

PartialRoom::PartialRoom(bool replace, const fs::path& out, FileLock::Use use)
    : out_(without_trailing_slash(out)),
      directory_((require_free(out_, replace), made_directory(partial_path(out_)))),
      replace_(replace),
      lock_(directory_ / kLockFile,
            "another raywalk-build-lf is packing this room; wait for it to finish", use) {}

PartialRoom::PartialRoom(const fs::path& out, const std::string& fingerprint, bool replace,
                         FileLock::Use use)
    : PartialRoom(replace, out, use) {
  if (lock_.alone()) prepare(fingerprint);
  if (use == FileLock::Use::kShared) lock_.share();
  if (!is_of(fingerprint)) throw_other_inputs();
}

PartialRoom::~PartialRoom() {
  if (!completed_ && !has_finished_volume()) discard();
}

void PartialRoom::prepare(const std::string& fingerprint) {
  std::error_code error;
  const fs::path inputs = directory_ / kFingerprintFile;
  for (const char* name : kVolumeDirectories) make_directories(directory_ / name);
  remove_unfinished_volumes(directory_);
  if (is_of(fingerprint)) return;
  if (has_finished_volume()) {
    if (!replace_ || !fs::exists(inputs, error)) throw_other_inputs();
    remove_volumes();
  }
  fs::remove_all(directory_ / kBlocksDirectory);
  write_file_atomically(inputs, fingerprint);
}

bool PartialRoom::is_of(const std::string& fingerprint) const {
  std::error_code error;
  const fs::path inputs = directory_ / kFingerprintFile;
  return fs::exists(inputs, error) && read_file(inputs) == fingerprint;
}

void PartialRoom::throw_other_inputs() const {
  throw Error(
      fmt::format("{}: holds an unfinished room of other frames, distances or options; "
                  "remove it, or start afresh with --force",
                  directory_.string()));
}

void PartialRoom::note_blocks(int count) const {
  note_block_count(directory_ / kBlocksDirectory, count);
}

std::string PartialRoom::missing_blocks(const std::function<bool(Block)>& is_missing) const {
  return raywalk::missing_blocks(directory_ / kBlocksDirectory, is_missing);
}

void PartialRoom::discard() {
  std::error_code ignored;
  if (lock_.try_alone()) fs::remove_all(directory_, ignored);
}

void PartialRoom::remove_volumes() {
  for (const char* name : kVolumeDirectories) {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory_ / name)) {
      fs::remove(entry.path());
    }
  }
}

void PartialRoom::complete() {
  require_free(out_, replace_);
  for (const char* name : {kLockFile, kFingerprintFile, kBlocksDirectory, kDevelopedDirectory}) {
    fs::remove_all(directory_ / name);
  }
  remove_unfinished_volumes(directory_);
  for (const char* name : {"distances/given", "distances/estimated", "distances"}) {
    if (fs::is_empty(directory_ / name)) fs::remove(directory_ / name);
  }
  move_into_place(directory_, out_);
  completed_ = true;
}

bool PartialRoom::has_finished_volume() const {
  std::error_code error;
  for (const char* name : kVolumeDirectories) {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory_ / name, error)) {
      if (is_finished_volume(entry.path())) return true;
    }
  }
  return false;
}

}  // namespace raywalk::build_lf
