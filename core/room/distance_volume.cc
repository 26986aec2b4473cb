#include "core/room/distance_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/files/fingerprint.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

void check_stations(const std::vector<int>& stations, int stations_of_line,
                    const std::string& file) {
  int previous = -1;
  for (int station : stations) {
    if (station < 0 || station >= stations_of_line) {
      throw Error(fmt::format("{}: station {} does not exist; the line has {}", file, station,
                              stations_of_line));
    }
    if (station <= previous) throw Error(file + ": dataset 'station' does not increase");
    previous = station;
  }
}

// The stored checksums of the maps; none in files of other programs.
std::string checksums_text(const Hdf5File& hdf5) {
  if (!hdf5.has_dataset("sha256")) return "";
  return fmt::format("{}", fmt::join(hdf5.read_strings("sha256"), "\n"));
}

}  // namespace

DistanceVolume DistanceVolume::open(const std::filesystem::path& file, int stations_of_line) {
  DistanceVolume volume;
  std::string checksums;
  std::vector<std::int32_t> left_out;
  {
    const Hdf5File hdf5 = Hdf5File::open(file);
    hdf5.require_format(kDistanceVolumeFormat);
    const std::vector<std::int32_t> stations = hdf5.read_int32("station");
    volume.stations_.assign(stations.begin(), stations.end());
    volume.origin_ = hdf5.text_attribute("origin").value_or(kGivenOrigin);
    volume.line_ = hdf5.text_attribute("line").value_or("");
    checksums = checksums_text(hdf5);
    if (hdf5.has_dataset("left_out")) left_out = hdf5.read_int32("left_out");
    if (hdf5.is_chunked("distance_m")) volume.deflated_ = std::make_shared<DeflatedMaps>(hdf5);
  }
  volume.bytes_ = stamp_of(file).bytes;
  check_stations(volume.stations_, stations_of_line, file.string());
  volume.stored_.resize(volume.stations_.size());
  std::iota(volume.stored_.begin(), volume.stored_.end(), 0);
  std::vector<std::size_t> shape;
  bool alike = true;
  if (volume.deflated_) {
    shape = volume.deflated_->shape();
    volume.distance_m_ = {volume.deflated_, volume.deflated_->distance_m()};
    volume.confidence_ = {volume.deflated_, volume.deflated_->confidence()};
  } else {
    const auto distance_m = std::make_shared<MappedDataset>(
        MappedDataset::open(file, "distance_m", ElementType::kFloat32));
    const auto confidence = std::make_shared<MappedDataset>(
        MappedDataset::open(file, "confidence", ElementType::kUint8));
    volume.distance_m_ = {distance_m, static_cast<const float*>(distance_m->data())};
    volume.confidence_ = {confidence, static_cast<const std::uint8_t*>(confidence->data())};
    shape = distance_m->shape();
    alike = confidence->shape() == shape;
  }
  if (shape.size() != 3 || shape[0] != volume.stations_.size() || shape[1] != 2 * shape[2] ||
      shape[1] > static_cast<std::size_t>(std::numeric_limits<int>::max()) || !alike) {
    throw Error(
        fmt::format("{}: 'distance_m' and 'confidence' are not both [{} maps][theta][phi] with "
                    "twice as many theta as phi",
                    file.string(), volume.stations_.size()));
  }
  volume.size_ = {static_cast<int>(shape[1]), static_cast<int>(shape[2])};
  std::string header = fmt::format("{} {} {} {}\n{}", volume.line_, volume.origin_,
                                   volume.size_.width, fmt::join(volume.stations_, ","), checksums);
  if (!left_out.empty()) {
    volume.left_out_ = LeftOutPixels(left_out, volume.size_, stations_of_line, file.string());
    header += fmt::format("\n{}", fmt::join(left_out, ","));
  }
  volume.header_sha256_ = sha256_hex(header);
  return volume;
}

DistanceVolume DistanceVolume::subset(std::span<const int> stations_of_line) const {
  DistanceVolume part = *this;
  part.stations_.clear();
  part.stored_.clear();
  for (size_t station = 0; station < stations_of_line.size(); ++station) {
    const auto found =
        std::lower_bound(stations_.begin(), stations_.end(), stations_of_line[station]);
    if (found == stations_.end() || *found != stations_of_line[station]) continue;
    part.stations_.push_back(static_cast<int>(station));
    part.stored_.push_back(stored_[static_cast<size_t>(found - stations_.begin())]);
  }
  part.left_out_ = left_out_.subset(stations_of_line);
  return part;
}

DistanceVolume DistanceVolume::with_maps(std::vector<int> stations, PanoramaSize size,
                                         std::vector<float> distance_m,
                                         std::vector<std::uint8_t> confidence) const {
  DistanceVolume other = *this;
  other.stored_.resize(stations.size());
  std::iota(other.stored_.begin(), other.stored_.end(), 0);
  other.stations_ = std::move(stations);
  other.size_ = size;
  other.deflated_.reset();
  const auto distances = std::make_shared<const std::vector<float>>(std::move(distance_m));
  const auto confidences = std::make_shared<const std::vector<std::uint8_t>>(std::move(confidence));
  other.distance_m_ = {distances, distances->data()};
  other.confidence_ = {confidences, confidences->data()};
  return other;
}

}  // namespace raywalk
