#include "build_lf/pack/room_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";
constexpr std::array kVolumeFolders = {"lines", "distances/given", "distances/estimated",
                                       kDevelopedDirectory};

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

OwnOutput own_room() { return {"a room", "manifest.json", "\"raywalk-room\"", is_part_of_room}; }

// The folder for a room at `out`, which must be free.
fs::path made_folder(const fs::path& out, bool replace) {
  require_free(out, replace);
  fs::path folder = out.string() + ".partial";
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) throw Error(fmt::format("cannot make {}: {}", folder.string(), error.message()));
  return folder;
}

// The volumes in a room, relative to it: those that are finished, or what a killed run left of
// others, whose names start with a dot.
std::vector<fs::path> volumes_in(const fs::path& room, bool finished) {
  std::vector<fs::path> found;
  std::error_code missing;
  for (const char* name : kVolumeFolders) {
    for (const fs::directory_entry& entry : fs::directory_iterator(room / name, missing)) {
      const fs::path file = entry.path().filename();
      const bool is_unfinished = file.string().front() == '.';
      const bool is_finished = !is_unfinished && file.extension() == ".h5";
      if (finished ? is_finished : is_unfinished) found.push_back(fs::path(name) / file);
    }
  }
  return found;
}

void remove_all(const fs::path& room, const std::vector<fs::path>& files) {
  for (const fs::path& file : files) fs::remove(room / file);
}

}  // namespace

void require_replaceable_room(const fs::path& out) { require_replaceable(out, own_room()); }

void require_free(const fs::path& out, bool replace) {
  raywalk::require_free(out, replace, own_room());
}

RoomFolder::RoomFolder(const fs::path& out, const std::vector<PlannedVolume>& volumes, bool replace,
                       FileLock::Use use)
    : out_(without_trailing_slash(out)),
      replace_(replace),
      directory_(made_folder(out_, replace)),
      lock_(directory_ / kLockFile,
            "another raywalk-build-lf is packing this room; wait for it to finish", use) {
  if (lock_.alone()) {
    for (const char* name : kVolumeFolders) make_directories(directory_ / name);
    remove_all(directory_, volumes_in(directory_, false));
  }
  const std::vector<fs::path> others = volumes_not_in(volumes);
  if (!others.empty()) {
    // A folder with a manifest is a room that someone gave this name.
    if (!replace || !lock_.alone() || fs::exists(manifest_path(directory_))) {
      throw Error(
          fmt::format("{}: holds an unfinished room of other frames, distances or options; "
                      "remove it, or start afresh with --force",
                      directory_.string()));
    }
    remove_all(directory_, others);
  }
  if (use == FileLock::Use::kShared) lock_.share();
}

RoomFolder::~RoomFolder() {
  if (completed_ || !volumes_in(directory_, true).empty() || !lock_.try_alone()) return;
  std::error_code ignored;
  fs::remove(directory_ / kLockFile, ignored);
  remove_empty_folders();
  fs::remove(directory_, ignored);
}

std::vector<fs::path> RoomFolder::volumes_not_in(const std::vector<PlannedVolume>& plan) const {
  std::vector<fs::path> found = volumes_in(directory_, true);
  std::erase_if(found, [&](const fs::path& file) {
    const auto planned = std::ranges::find(plan, file, &PlannedVolume::file);
    return planned != plan.end() && inputs_of(directory_ / file) == planned->inputs;
  });
  return found;
}

void RoomFolder::remove_empty_folders() const {
  std::error_code not_empty;
  for (const char* name : kVolumeFolders) fs::remove(directory_ / name, not_empty);
  fs::remove(directory_ / "distances", not_empty);
}

bool RoomFolder::has(const fs::path& file) const { return fs::exists(directory_ / file); }

bool RoomFolder::take_over(const PlannedVolume& volume) const {
  if (!replace_ || inputs_of(out_ / volume.file) != volume.inputs) return false;
  throw_if_interrupted();
  std::error_code error;
  fs::create_hard_link(out_ / volume.file, directory_ / volume.file, error);
  if (error) copy_volume(out_ / volume.file, directory_ / volume.file);
  return true;
}

void RoomFolder::complete(const RoomManifest& manifest) {
  write_file_atomically(manifest_path(directory_), manifest_to_json(manifest));
  Room::open(directory_);  // checks that the result can be opened
  require_free(out_, replace_);
  fs::remove_all(directory_ / kDevelopedDirectory);
  remove_all(directory_, volumes_in(directory_, false));
  fs::remove(directory_ / kLockFile);
  remove_empty_folders();
  move_into_place(directory_, out_);
  completed_ = true;
}

}  // namespace raywalk::build_lf
