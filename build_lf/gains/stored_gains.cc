#include "build_lf/gains/stored_gains.h"

#include <algorithm>
#include <system_error>

#include "build_lf/distances_lock.h"
#include "core/files/atomic_output.h"
#include "core/files/directory_moves.h"
#include "core/room/connection_errors.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

bool all_are_one(const GainFields& fields) {
  return std::ranges::all_of(fields,
                             [](const auto& line) { return std::ranges::all_of(line, is_one); });
}

void write_manifest(const fs::path& room, const RoomManifest& manifest) {
  write_file_atomically(manifest_path(room), manifest_to_json(manifest));
}

void remove_measurements(const fs::path& room) {
  std::error_code ignored;
  fs::remove(connection_errors_path(room), ignored);
}

}  // namespace

void replace_gains(const fs::path& room, const GainFields& fields) {
  if (all_are_one(fields)) {
    remove_gains(room);
    return;
  }
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  const fs::path made = room / "gains.new.h5";
  write_gain_fields(made, manifest.grid, fields);
  const GainsRecord record = record_of_gains(made);
  remove_measurements(room);
  // Without old gains the new file comes first: one that is not recorded is not used.
  if (!manifest.gains.empty()) {
    manifest.gains.push_back(record);
    write_manifest(room, manifest);
  }
  rename_or_throw(made, gains_path(room));
  manifest.gains = {record};
  write_manifest(room, manifest);
}

bool remove_gains(const fs::path& room) {
  const DistancesLock lock(room);
  RoomManifest manifest = read_manifest(room);
  const bool recorded = !manifest.gains.empty();
  if (recorded) {
    remove_measurements(room);
    manifest.gains.clear();
    write_manifest(room, manifest);
  }
  std::error_code ignored;
  return fs::remove(gains_path(room), ignored) || recorded;
}

}  // namespace raywalk::build_lf
