#include "core/room/room.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <functional>
#include <system_error>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/words.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// A manifest has about 150 bytes per station, so this allows 3,000,000 stations.
constexpr std::size_t kMaxManifestBytes = std::size_t{512} << 20;

// The names of the rooms in the folder where `room` would be.
std::vector<std::string> rooms_beside(const fs::path& room) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path folder = room.parent_path();
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    if (fs::exists(manifest_path(*entry), error)) names.push_back(entry->path().filename());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

fs::path manifest_path(const fs::path& room) { return room / "manifest.json"; }

fs::path line_volume_path(const fs::path& room, const std::string& line_id) {
  return room / "lines" / (line_id + ".h5");
}

fs::path distances_directory(const fs::path& room, DistanceKind kind) {
  return room / "distances" / name_of(kind);
}

fs::path distance_volume_path(const fs::path& room, const std::string& line_id, DistanceKind kind) {
  return distances_directory(room, kind) / (line_id + ".h5");
}

RoomManifest read_manifest(const fs::path& room) {
  std::error_code error;
  if (!fs::is_directory(room, error)) {
    const std::vector<std::string> rooms = rooms_beside(room);
    throw Error(room.string() + ": no such room" +
                (rooms.empty() ? "; `raywalk-build-lf pack` makes one"
                               : suggestion(room.filename().string(), rooms)));
  }
  const fs::path manifest = manifest_path(room);
  if (!fs::exists(manifest, error)) {
    throw Error(room.string() + ": not a room: it has no manifest.json");
  }
  return manifest_from_json(read_file(manifest, kMaxManifestBytes), manifest.string());
}

Room Room::open_rays(const fs::path& directory) {
  Room room;
  room.directory_ = directory;
  room.manifest_ = read_manifest(directory);
  for (const Line& line : room.grid().lines) {
    const int stations = static_cast<int>(line.stations.size());
    room.volumes_.push_back(
        LineVolume::open(line_volume_path(directory, line.id), stations, room.panorama()));
    room.distances_.emplace_back();
  }
  return room;
}

Room Room::open_without_gains(const fs::path& directory) {
  Room room = open_rays(directory);
  room.open_distances();
  return room;
}

Room Room::open(const fs::path& directory) {
  Room room = open_without_gains(directory);
  room.open_gains();
  return room;
}

void Room::open_distances() {
  if (manifest_.distances == DistanceKind::kNone) return;
  try {
    distances_ =
        open_distance_volumes(distances_directory(directory_, manifest_.distances), grid());
  } catch (const Error& unusable) {
    throw Error(fmt::format(
        "{}; put the room's own file back, estimate again (`raywalk-build-lf depth {}`), or use "
        "other distances (`raywalk-build-lf distances {} --use`)",
        unusable.what(), shell_word(directory_.string()), shell_word(directory_.string())));
  }
}

void Room::open_gains() {
  const fs::path file = gains_path(directory_);
  std::error_code error;
  if (!manifest_.gains) {
    if (fs::exists(file, error)) {
      spdlog::warn("{}: not recorded in the room's manifest, so it is not used", file.string());
    }
    return;
  }
  try {
    gains_ = read_gain_fields(file, grid());
  } catch (const Error& unusable) {
    throw Error(fmt::format(
        "{}; put the room's own file back, solve for the gains again (`raywalk-build-lf gains "
        "{}`), or remove them (`raywalk-build-lf gains {} --remove`)",
        unusable.what(), shell_word(directory_.string()), shell_word(directory_.string())));
  }
}

Room Room::subset(const KeptStations& kept) const {
  if (kept.size() != volumes_.size()) {
    throw UsageError("the selected stations are for another number of lines than the room has");
  }
  Room part;
  part.directory_ = directory_;
  part.manifest_ = manifest_;
  part.manifest_.distances = DistanceKind::kNone;  // their files are of all stations
  part.manifest_.gains = false;                    // the same
  for (std::size_t i = 0; i < kept.size(); ++i) {
    Line& line = part.manifest_.grid.lines[i];
    const std::vector<Station>& all = grid().lines[i].stations;
    line.stations.clear();
    const bool increasing = std::ranges::is_sorted(kept[i], std::less_equal());
    if (kept[i].size() < 2) {
      throw UsageError("line " + line.id + " would have fewer than two stations; leave out fewer");
    }
    if (!increasing || kept[i].front() < 0 || kept[i].back() >= static_cast<int>(all.size())) {
      throw UsageError("line " + line.id +
                       ": a selected station does not exist or is selected twice");
    }
    double height_sum_m = 0.0;
    for (const int station : kept[i]) {
      line.stations.push_back(all[static_cast<size_t>(station)]);
      height_sum_m += line.stations.back().position_m.y();
    }
    line.height_m = height_sum_m / static_cast<double>(kept[i].size());
    part.volumes_.push_back(volumes_[i].subset(kept[i]));
    part.distances_.push_back(distances_[i].subset(kept[i]));
    if (gains_.empty()) continue;
    auto& gains = part.gains_.emplace_back();
    for (const int station : kept[i]) gains.push_back(gains_[i][static_cast<size_t>(station)]);
  }
  return part;
}

Room Room::with_distances(const fs::path& directory) const {
  Room other = *this;
  other.distances_ = open_distance_volumes(directory, grid());
  return other;
}

bool Room::has_distances() const {
  return std::any_of(distances_.begin(), distances_.end(),
                     [](const DistanceVolume& volume) { return volume.maps() > 0; });
}

bool Room::masked() const {
  return std::any_of(volumes_.begin(), volumes_.end(),
                     [](const LineVolume& volume) { return volume.masked(); });
}

std::string distances_sha256(const Room& room) {
  std::string text;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const DistanceVolume& volume = room.distances(line);
    if (volume.maps() == 0) continue;
    const Line& of_line = room.grid().lines[static_cast<std::size_t>(line)];
    text += of_line.id;
    for (const int station : volume.stations()) {
      const Eigen::Vector3d& p = of_line.stations[static_cast<std::size_t>(station)].position_m;
      text += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
    }
    text += " " + volume.header_sha256() + "\n";
  }
  return sha256_hex(text);
}

std::string room_fingerprint(const Room& room) {
  RoomManifest manifest = room.manifest();
  manifest.distances = DistanceKind::kNone;  // those in use are compared instead
  std::string text = manifest_to_json(manifest) + distances_sha256(room);
  if (!room.gains().empty()) {
    text += Hdf5File::open(gains_path(room.directory())).text_attribute("sha256").value_or("");
  }
  return sha256_hex(text);
}

}  // namespace raywalk
