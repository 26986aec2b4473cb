#include "build_lf/depth/partial_maps.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <limits>
#include <system_error>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";
constexpr const char* kFingerprintFile = "inputs.sha256";
constexpr const char* kInstalled = "installed";

fs::path made_directory(const fs::path& directory) {
  make_directories(directory);
  return directory;
}

fs::path working_directory(const fs::path& room, MapsUse use) {
  fs::path directory = room / "distances.partial";
  std::error_code error;
  if (use == MapsUse::kShared && !fs::exists(directory / kFingerprintFile, error)) {
    throw Error(fmt::format("{}: no maps have been begun; run depth with --step prepare first",
                            room.string()));
  }
  return made_directory(directory);
}

// Of a map's file, which goes on with the inverse distances and the confidences.
struct MapHeader {
  std::array<double, 3> position_m{};
  std::int32_t width = 0;
  std::int32_t height = 0;
};

std::string map_name(const std::string& stage, StationIndex station) {
  return fmt::format("{}-{}-{}.map", stage, station.line, station.station);
}

StationDistances stored_distances(const InverseDistanceMap& map) {
  StationDistances station;
  station.confidence = map.confidence;
  station.distance_m.reserve(map.inverse.size());
  for (const float inverse : map.inverse) {
    station.distance_m.push_back(inverse > 0.0f ? 1.0f / inverse
                                                : std::numeric_limits<float>::infinity());
  }
  station.sha256 = checksum_of_distances(station.distance_m, station.confidence);
  return station;
}

// The stations of a line that have maps.
std::vector<std::int32_t> mapped_stations(const DepthPlan& plan, std::size_t line) {
  std::vector<std::int32_t> stations;
  for (const SweepReference& map : plan.maps) {
    if (map.station.line == static_cast<int>(line)) stations.push_back(map.station.station);
  }
  return stations;
}

}  // namespace

PartialMaps::PartialMaps(const fs::path& room, const std::string& fingerprint, MapsUse use,
                         const std::string& volumes)
    : room_(room),
      directory_(working_directory(room, use)),
      volumes_(directory_ / volumes),
      lock_(directory_ / kLockFile,
            "another raywalk-build-lf is estimating this room's distances; wait for it to finish",
            use == MapsUse::kShared ? FileLock::Use::kShared : FileLock::Use::kAlone) {
  if (use == MapsUse::kAlone) {
    prepare(fingerprint);
    return;
  }
  lock_.share();
  made_directory(volumes_);
  if (is_of(fingerprint)) return;
  throw Error(fmt::format(
      "{}: holds unfinished maps of other options or of the room as it was; give the same options, "
      "or begin with --step prepare",
      directory_.string()));
}

PartialMaps::~PartialMaps() {
  std::error_code ignored;
  if (removable_) fs::remove_all(directory_, ignored);
}

void PartialMaps::prepare(const std::string& fingerprint) {
  std::error_code error;
  if (!is_of(fingerprint)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(directory_)) {
      if (entry.path().filename() != kLockFile) fs::remove_all(entry.path(), error);
    }
    write_file_atomically(directory_ / kFingerprintFile, fingerprint);
    removable_ = true;
  }
  fs::remove_all(directory_ / kInstalled);
  made_directory(volumes_);
  // What killed runs left unfinished; nobody is writing now.
  for (const fs::directory_entry& entry : fs::directory_iterator(volumes_)) {
    if (entry.path().filename().string().starts_with(".")) fs::remove(entry.path(), error);
  }
}

bool PartialMaps::is_of(const std::string& fingerprint) const {
  const fs::path inputs = directory_ / kFingerprintFile;
  std::error_code error;
  return fs::exists(inputs, error) && read_file(inputs) == fingerprint;
}

// File content: the bytes and the checksum of them.
void PartialMaps::store_bytes(const std::string& name, std::string bytes) {
  bytes += sha256_hex(bytes);
  write_file_atomically(directory_ / name, bytes);
  removable_ = false;
}

std::optional<std::string> PartialMaps::load_bytes(const std::string& name) const {
  constexpr size_t kChecksum = 64;
  std::error_code error;
  if (!fs::exists(directory_ / name, error)) return std::nullopt;
  std::string bytes = read_file(directory_ / name);
  if (bytes.size() < kChecksum) return std::nullopt;
  const std::string checksum = bytes.substr(bytes.size() - kChecksum);
  bytes.resize(bytes.size() - kChecksum);
  if (sha256_hex(bytes) != checksum) return std::nullopt;
  return bytes;
}

void PartialMaps::store(const std::string& stage, const InverseDistanceMap& map) {
  const MapHeader header{{map.position_m.x(), map.position_m.y(), map.position_m.z()},
                         map.size.width,
                         map.size.height};
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof(header));
  bytes.append(reinterpret_cast<const char*>(map.inverse.data()),
               map.inverse.size() * sizeof(float));
  bytes.append(reinterpret_cast<const char*>(map.confidence.data()), map.confidence.size());
  store_bytes(map_name(stage, map.station), std::move(bytes));
}

bool PartialMaps::has(const std::string& stage, StationIndex station) const {
  std::error_code error;
  return fs::exists(directory_ / map_name(stage, station), error);
}

std::optional<InverseDistanceMap> PartialMaps::load(const std::string& stage,
                                                    StationIndex station) const {
  const std::optional<std::string> bytes = load_bytes(map_name(stage, station));
  if (!bytes) return std::nullopt;
  MapHeader header;
  std::memcpy(&header, bytes->data(), sizeof(header));
  const size_t pixels = static_cast<size_t>(header.width) * static_cast<size_t>(header.height);
  InverseDistanceMap map{station,
                         Eigen::Vector3d(header.position_m.data()),
                         {header.width, header.height},
                         std::vector<float>(pixels),
                         std::vector<std::uint8_t>(pixels)};
  const char* const inverse = bytes->data() + sizeof(header);
  std::memcpy(map.inverse.data(), inverse, pixels * sizeof(float));
  std::memcpy(map.confidence.data(), inverse + pixels * sizeof(float), pixels);
  return map;
}

InverseDistanceMap PartialMaps::stored(const std::string& stage, StationIndex station) const {
  auto map = load(stage, station);
  if (!map) {
    std::error_code ignored;
    fs::remove(directory_ / map_name(stage, station), ignored);
    throw Error(directory_.string() + ": a map is damaged; run the command again");
  }
  return std::move(*map);
}

void PartialMaps::complete() {
  const fs::path place = distances_directory(room_, DistanceKind::kEstimated);
  make_directories(place.parent_path());
  // Under another name first: a run that is killed after the exchange leaves the previous distances
  // there, which are not taken for the new ones.
  const fs::path installed = directory_ / kInstalled;
  move_into_place(volumes_, installed);
  move_into_place(installed, place);
  std::error_code error;
  fs::remove_all(directory_, error);
}

void make_maps(const DepthPlan& plan, IndexRange share, const char* stage, const char* doing,
               PartialMaps* partial, const std::function<InverseDistanceMap(int map)>& make) {
  Progress progress(doing, static_cast<std::int64_t>(share.size()), "maps");
  for (auto i = static_cast<int>(share.begin); i < static_cast<int>(share.end); ++i) {
    throw_if_interrupted();
    if (!partial->load(stage, plan.station_of(i))) partial->store(stage, make(i));
    progress.advance();
  }
}

void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, IndexRange lines,
                   const LineSearch& contradictions_of) {
  const double half_pixel_per_m = 0.5 / plan.pixels_per_inverse_m();
  std::int64_t count = 0;
  for (std::size_t l = lines.begin; l < lines.end; ++l) {
    count += std::ssize(mapped_stations(plan, l));
  }
  Progress progress("finishing lines", count, "maps");
  for (std::size_t l = lines.begin; l < lines.end; ++l) {
    const Line& line = room.grid().lines[l];
    const fs::path volume = partial.volumes() / (line.id + ".h5");
    if (fs::exists(volume)) {
      for (std::size_t i = mapped_stations(plan, l).size(); i > 0; --i) progress.advance();
      continue;
    }
    DistanceMaps maps{mapped_stations(plan, l), plan.size, "estimated by " + name_of(method), {}};
    const Contradictions contradictions = contradictions_of(static_cast<int>(l));
    maps.read = [&](std::size_t i) {
      InverseDistanceMap map = partial.stored(kFinalStage, {static_cast<int>(l), maps.stations[i]});
      show_behind(contradictions, half_pixel_per_m, &map);
      return stored_distances(map);
    };
    for (const ContradictedStation& found : contradictions.stations) {
      maps.left_out.insert(maps.left_out.end(), found.runs.begin(), found.runs.end());
    }
    maps.compressed = room.volume(static_cast<int>(l)).form().compressed();
    write_distance_volume(volume, line, maps, &progress);
  }
}

}  // namespace raywalk::build_lf
