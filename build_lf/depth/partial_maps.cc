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

std::span<const std::byte> bytes_of(const InverseDistanceMap& map) {
  return std::as_bytes(std::span(map.omega));
}

}  // namespace

PartialMaps::PartialMaps(const fs::path& room, const std::string& fingerprint)
    : room_(room),
      directory_(made_directory(room / "distances.partial")),
      volumes_(made_directory(directory_ / "volumes")),
      lock_(directory_ / kLockFile,
            "another raywalk-build-lf is estimating this room's distances; wait for it to finish") {
  const fs::path inputs = directory_ / kFingerprintFile;
  std::error_code error;
  if (fs::exists(inputs, error) && read_file(inputs) == fingerprint) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_)) {
    if (entry.path().filename() != kLockFile) fs::remove_all(entry.path(), error);
  }
  made_directory(volumes_);
  write_file_atomically(inputs, fingerprint);
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
  if (!map) throw Error(directory_.string() + ": a map is damaged; run the command again");
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
