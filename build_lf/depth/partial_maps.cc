#include "build_lf/depth/partial_maps.h"

#include <fmt/format.h>

#include <cstring>
#include <span>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/directory_moves.h"
#include "core/files/sha256.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = "lock";
constexpr const char* kFingerprintFile = "inputs.sha256";

fs::path made_directory(const fs::path& directory) {
  make_directories(directory);
  return directory;
}

fs::path working_directory(const fs::path& room, MapsUse use) {
  fs::path directory = room / "distances.partial";
  std::error_code error;
  if (use == MapsUse::kMerge && !fs::exists(directory, error)) {
    throw Error(fmt::format("{}: there is nothing to merge; make the blocks of all steps first",
                            room.string()));
  }
  return made_directory(directory);
}

std::span<const std::byte> bytes_of(const InverseDistanceMap& map) {
  return std::as_bytes(std::span(map.omega));
}

}  // namespace

PartialMaps::PartialMaps(const fs::path& room, const std::string& fingerprint, MapsUse use)
    : room_(room),
      directory_(working_directory(room, use)),
      volumes_(directory_ / "volumes"),
      lock_(directory_ / kLockFile,
            "another raywalk-build-lf is estimating this room's distances; wait for it to finish",
            use == MapsUse::kBlock ? FileLock::Use::kShared : FileLock::Use::kAlone) {
  if (lock_.alone()) prepare(fingerprint, use);
  if (use == MapsUse::kBlock) lock_.share();
  if (!is_of(fingerprint)) throw_other_inputs();
}

PartialMaps::~PartialMaps() {
  std::error_code ignored;
  if (removable_) fs::remove_all(directory_, ignored);
}

void PartialMaps::prepare(const std::string& fingerprint, MapsUse use) {
  std::error_code error;
  const fs::path inputs = directory_ / kFingerprintFile;
  if (!is_of(fingerprint)) {
    if (use != MapsUse::kWhole && fs::exists(inputs, error)) throw_other_inputs();
    for (const fs::directory_entry& entry : fs::directory_iterator(directory_)) {
      if (entry.path().filename() != kLockFile) fs::remove_all(entry.path(), error);
    }
    write_file_atomically(inputs, fingerprint);
    removable_ = use == MapsUse::kWhole;
  }
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

void PartialMaps::throw_other_inputs() const {
  throw Error(fmt::format(
      "{}: holds unfinished maps of other options or of the room as it was; give the same options, "
      "or remove it",
      directory_.string()));
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

void PartialMaps::complete(const std::string& keep_as) {
  const fs::path distances = room_ / "distances";
  std::error_code error;
  if (!fs::exists(distances, error)) {
    rename_or_throw(volumes_, distances);
  } else {
    // The kept directory gets its new name before it loses the old one, so that a crash cannot lose
    // it.
    if (!keep_as.empty()) {
      const fs::path kept = directory_ / "kept";
      copy_by_links(distances, kept);
      fs::remove_all(room_ / keep_as, error);
      rename_or_throw(kept, room_ / keep_as);
    }
    if (!exchange(volumes_, distances)) {
      rename_or_throw(distances, directory_ / "replaced");
      rename_or_throw(volumes_, distances);
    }
  }
  fs::remove_all(directory_, error);
}

}  // namespace raywalk::build_lf
