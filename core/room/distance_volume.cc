#include "core/room/distance_volume.h"

#include <fmt/format.h>

#include <limits>

#include "core/base/error.h"
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

}  // namespace

DistanceVolume DistanceVolume::open(const std::filesystem::path& file, int stations_of_line) {
  DistanceVolume volume;
  {
    const Hdf5File hdf5 = Hdf5File::open(file);
    hdf5.require_format(kDistanceVolumeFormat);
    const std::vector<std::int32_t> stations = hdf5.read_int32("station");
    volume.stations_.assign(stations.begin(), stations.end());
    volume.given_ = hdf5.text_attribute("origin").value_or(kGivenOrigin) == kGivenOrigin;
  }
  check_stations(volume.stations_, stations_of_line, file.string());
  volume.distance_ = MappedDataset::open(file, "distance_m", ElementType::kFloat32);
  volume.confidence_ = MappedDataset::open(file, "confidence", ElementType::kUint8);
  const std::vector<std::size_t>& shape = volume.distance_.shape();
  if (shape.size() != 3 || shape[0] != volume.stations_.size() || shape[1] != 2 * shape[2] ||
      shape[1] > static_cast<std::size_t>(std::numeric_limits<int>::max()) ||
      volume.confidence_.shape() != shape) {
    throw Error(
        fmt::format("{}: 'distance_m' and 'confidence' are not both [{} maps][theta][phi] with "
                    "twice as many theta as phi",
                    file.string(), volume.stations_.size()));
  }
  volume.size_ = {static_cast<int>(shape[1]), static_cast<int>(shape[2])};
  return volume;
}

}  // namespace raywalk
