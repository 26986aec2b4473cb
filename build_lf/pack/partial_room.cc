#include "build_lf/pack/partial_room.h"

#include <fmt/format.h>

#include <array>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";
constexpr const char* kFingerprintFile = "inputs.sha256";
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

// The volumes of an unfinished room that are finished, or what else a killed run left beside them:
// temporary files start with a dot.
std::vector<fs::path> volumes_in(const fs::path& room, bool finished) {
  std::vector<fs::path> found;
  std::error_code missing;
  for (const char* name : kVolumeDirectories) {
    for (const fs::directory_entry& entry : fs::directory_iterator(room / name, missing)) {
      const fs::path extension = entry.path().extension();
      const bool is_volume = extension == ".h5" || extension == kDevelopedExtension;
      const bool is_finished = is_volume && !entry.path().filename().string().starts_with(".");
      if (is_finished == finished) found.push_back(entry.path());
    }
  }
  return found;
}

void remove_all(const std::vector<fs::path>& files) {
  for (const fs::path& file : files) fs::remove(file);
}

OwnOutput own_room() { return {"a room", "manifest.json", "\"raywalk-room\"", is_part_of_room}; }

}  // namespace

void require_replaceable_room(const fs::path& out) { require_replaceable(out, own_room()); }

void require_free(const fs::path& out, bool replace) {
  raywalk::require_free(out, replace, own_room());
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
  if (!completed_ && volumes_in(directory_, true).empty()) discard();
}

void PartialRoom::prepare(const std::string& fingerprint) {
  std::error_code error;
  const fs::path inputs = directory_ / kFingerprintFile;
  for (const char* name : kVolumeDirectories) make_directories(directory_ / name);
  remove_all(volumes_in(directory_, false));
  if (is_of(fingerprint)) return;
  const std::vector<fs::path> of_others = volumes_in(directory_, true);
  if (!of_others.empty() && !(replace_ && fs::exists(inputs, error))) throw_other_inputs();
  remove_all(of_others);
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

void PartialRoom::discard() {
  std::error_code ignored;
  if (lock_.try_alone()) fs::remove_all(directory_, ignored);
}

void PartialRoom::complete() {
  require_free(out_, replace_);
  for (const char* name : {kLockFile, kFingerprintFile, kDevelopedDirectory}) {
    fs::remove_all(directory_ / name);
  }
  remove_all(volumes_in(directory_, false));
  for (const char* name : {"distances/given", "distances/estimated", "distances"}) {
    if (fs::is_empty(directory_ / name)) fs::remove(directory_ / name);
  }
  move_into_place(directory_, out_);
  completed_ = true;
}

}  // namespace raywalk::build_lf
