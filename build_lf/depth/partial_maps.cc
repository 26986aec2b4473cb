#include "build_lf/depth/partial_maps.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <span>
#include <system_error>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
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

std::span<const std::byte> bytes_of(const InverseDistanceMap& map) {
  return std::as_bytes(std::span(map.omega));
}

StationDistances stored_distances(const InverseDistanceMap& map) {
  StationDistances station;
  station.confidence = map.confidence;
  station.distance_m.reserve(map.omega.size());
  for (const float omega : map.omega) {
    station.distance_m.push_back(omega > 0.0f ? 1.0f / omega
                                              : std::numeric_limits<float>::infinity());
  }
  station.sha256 = checksum_of_distances(station.distance_m, station.confidence);
  return station;
}

// The contradicted pixels of a line's stations as DistanceMaps::left_out.
std::vector<std::int32_t> left_out_of(const Contradictions& of_line) {
  std::vector<std::int32_t> runs;
  for (const ContradictedStation& found : of_line.stations) {
    for (std::size_t i = 0; i < found.runs.size(); i += 3) {
      runs.insert(runs.end(),
                  {found.station.station, found.runs[i], found.runs[i + 1], found.runs[i + 2]});
    }
  }
  return runs;
}

std::vector<SweepReference> maps_of_line(const DepthPlan& plan, std::size_t line) {
  std::vector<SweepReference> of_line;
  for (const SweepReference& reference : plan.maps) {
    if (reference.station.line == static_cast<int>(line)) of_line.push_back(reference);
  }
  return of_line;
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

fs::path PartialMaps::file_of(const std::string& stage, StationIndex station) const {
  return directory_ / fmt::format("{}-{}-{}.map", stage, station.line, station.station);
}

// File content: the bytes of omega, those of confidence, and the checksum of both.
void PartialMaps::store(const std::string& stage, const InverseDistanceMap& map) {
  std::string text(reinterpret_cast<const char*>(bytes_of(map).data()), bytes_of(map).size());
  text.append(reinterpret_cast<const char*>(map.confidence.data()), map.confidence.size());
  text += sha256_hex(text);
  write_file_atomically(file_of(stage, map.station), text);
  removable_ = false;
}

bool PartialMaps::has(const std::string& stage, StationIndex station) const {
  std::error_code error;
  return fs::exists(file_of(stage, station), error);
}

std::optional<InverseDistanceMap> PartialMaps::load(const std::string& stage, StationIndex station,
                                                    const Eigen::Vector3d& position_m,
                                                    PanoramaSize size) const {
  constexpr size_t kChecksum = 64;
  const fs::path file = file_of(stage, station);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const std::string text = read_file(file);
  const size_t pixels = static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  const size_t data = pixels * (sizeof(float) + 1);
  if (text.size() != data + kChecksum ||
      sha256_hex(std::as_bytes(std::span(text).first(data))) != text.substr(data)) {
    return std::nullopt;
  }
  InverseDistanceMap map{station, position_m, size, std::vector<float>(pixels),
                         std::vector<std::uint8_t>(pixels)};
  std::memcpy(map.omega.data(), text.data(), pixels * sizeof(float));
  std::memcpy(map.confidence.data(), text.data() + pixels * sizeof(float), pixels);
  return map;
}

InverseDistanceMap PartialMaps::load_stored(const std::string& stage, StationIndex station,
                                            const Eigen::Vector3d& position_m,
                                            PanoramaSize size) const {
  auto map = load(stage, station, position_m, size);
  if (!map) {
    std::error_code ignored;
    fs::remove(file_of(stage, station), ignored);
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

void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, IndexRange lines,
                   const LineSearch& contradictions_of) {
  const double half_pixel_per_m = 0.5 / plan.pixels_per_omega_m();
  std::int64_t count = 0;
  for (std::size_t l = lines.begin; l < lines.end; ++l) count += std::ssize(maps_of_line(plan, l));
  Progress progress("finishing lines", count, "maps");
  for (std::size_t l = lines.begin; l < lines.end; ++l) {
    const std::vector<SweepReference> of_line = maps_of_line(plan, l);
    const Line& line = room.grid().lines[l];
    const fs::path volume = partial.volumes() / (line.id + ".h5");
    if (fs::exists(volume)) {
      for (std::size_t i = 0; i < of_line.size(); ++i) progress.advance();
      continue;
    }
    DistanceMaps maps{{}, plan.size, "estimated by " + name_of(method), {}};
    for (const SweepReference& reference : of_line) {
      maps.stations.push_back(reference.station.station);
    }
    const Contradictions contradictions = contradictions_of(static_cast<int>(l));
    maps.read = [&](std::size_t i) {
      InverseDistanceMap map =
          partial.load_stored(kFinalStage, of_line[i].station, of_line[i].position_m, plan.size);
      show_behind(contradictions, half_pixel_per_m, &map);
      return stored_distances(map);
    };
    maps.left_out = left_out_of(contradictions);
    maps.compressed = room.volume(static_cast<int>(l)).form().compressed();
    write_distance_volume(volume, line, maps, &progress);
  }
}

}  // namespace raywalk::build_lf
