#include "core/room/distance_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/files/fingerprint.h"
#include "core/room/hdf5_file.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostWidth = 1 << 20;

void check_stations(const std::vector<int>& stations, const Line& line, const std::string& file) {
  int previous = -1;
  for (const int station : stations) {
    if (station < 0 || station >= std::ssize(line.stations)) {
      throw Error(fmt::format("{}: station {} does not exist; the line has {}", file, station,
                              line.stations.size()));
    }
    if (station <= previous) throw Error(file + ": dataset 'station' does not increase");
    previous = station;
  }
}

void check_line(const Hdf5File& hdf5, const Line& line) {
  const std::string file = hdf5.path().string();
  const std::string holds = hdf5.text_attribute("line").value_or(line.id);
  if (holds != line.id) throw Error(fmt::format("{}: holds the distances of line {}", file, holds));
  const auto stations = hdf5.text_attribute("stations_sha256");
  if (stations && *stations != sha256_of(line)) {
    throw Error(file + ": holds the distances of another room, whose stations are elsewhere");
  }
}

PanoramaSize size_of_maps(const Hdf5File& hdf5, std::size_t maps) {
  const Shape shape = hdf5.shape_of("distance_m");
  if (shape.size() != 3 || shape[0] != maps || shape[1] != 2 * shape[2] || shape[1] > kMostWidth ||
      hdf5.shape_of("confidence") != shape) {
    throw Error(
        fmt::format("{}: 'distance_m' and 'confidence' are not both [{} maps][theta][phi] with "
                    "twice as many theta as phi",
                    hdf5.path().string(), maps));
  }
  return {static_cast<int>(shape[1]), static_cast<int>(shape[2])};
}

}  // namespace

std::string sha256_of(const Line& line) {
  std::string text = line.id;
  for (const Station& station : line.stations) {
    const Eigen::Vector3d& p = station.position_m;
    text += fmt::format(" {},{},{}", p.x(), p.y(), p.z());
  }
  return sha256_hex(text);
}

std::string sha256_of(const DistanceHeader& header) {
  return sha256_hex(fmt::format("{} {} {} {}\n{}\n{}", header.line, header.origin,
                                header.size.width, fmt::join(header.stations, ","),
                                fmt::join(header.map_sha256, "\n"),
                                fmt::join(header.left_out, ",")));
}

LeftOutPixels::LeftOutPixels(std::span<const std::int32_t> runs, PanoramaSize size, int stations,
                             const std::string& source)
    : size_(size) {
  if (runs.size() % 4 != 0) {
    throw Error(source + ": 'left_out' is not [run][station, theta, first row, one past the last]");
  }
  for (std::size_t i = 0; i < runs.size(); i += 4) {
    const LeftOutRun run{{runs[i + 2], runs[i + 3]}, runs[i], runs[i + 1]};
    const bool inside = run.station >= 0 && run.station < stations && run.theta >= 0 &&
                        run.theta < size.width && run.begin >= 0 && run.begin < run.end &&
                        run.end <= size.height;
    if (!inside) {
      throw Error(
          fmt::format("{}: 'left_out' names rows {} to {} of column {} of station {}, which "
                      "do not exist",
                      source, run.begin, run.end, run.theta, run.station));
    }
    runs_.push_back(run);
  }
  std::ranges::sort(runs_, {}, [](const LeftOutRun& run) {
    return std::tuple(run.station, run.theta, run.begin, run.end);
  });
}

LeftOutPixels LeftOutPixels::subset(std::span<const int> stations) const {
  LeftOutPixels part;
  part.size_ = size_;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (LeftOutRun run : runs_of(stations[i])) {
      run.station = static_cast<int>(i);
      part.runs_.push_back(run);
    }
  }
  return part;
}

std::vector<std::int32_t> LeftOutPixels::stored_runs(PanoramaSize size) const {
  // The first pixel of `to` that pixel `at` of `from` lies in.
  const auto first_of = [](int at, int from, int to) {
    return static_cast<int>(std::int64_t{at} * to / from);
  };
  std::vector<std::int32_t> stored;
  for (const LeftOutRun& run : runs_) {
    const int first = first_of(run.theta, size_.width, size.width);
    const int last = std::max(first, first_of(run.theta + 1, size_.width, size.width) - 1);
    const int begin = first_of(run.begin, size_.height, size.height);
    const int end = std::max(first_of(run.end - 1, size_.height, size.height) + 1,
                             first_of(run.end, size_.height, size.height));
    for (int column = first; column <= last; ++column) {
      stored.insert(stored.end(), {run.station, column, begin, end});
    }
  }
  return stored;
}

std::span<const LeftOutRun> LeftOutPixels::runs_of(int station) const {
  return {std::ranges::lower_bound(runs_, station, {}, &LeftOutRun::station),
          std::ranges::upper_bound(runs_, station, {}, &LeftOutRun::station)};
}

std::span<const LeftOutRun> LeftOutPixels::rows(int station, int theta) const {
  const std::span<const LeftOutRun> runs = runs_of(station);
  return {std::ranges::lower_bound(runs, theta, {}, &LeftOutRun::theta),
          std::ranges::upper_bound(runs, theta, {}, &LeftOutRun::theta)};
}

// Each map is decoded when it is first asked for, and kept.
class DistanceVolume::DeflatedMaps {
 public:
  DeflatedMaps(Hdf5File hdf5, std::size_t maps, PanoramaSize size)
      : hdf5_(std::move(hdf5)),
        pixels_(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height)),
        decoded_(maps),
        maps_(maps) {}

  const Map& map(std::size_t index) {
    std::call_once(decoded_[index], [&] {
      Map& map = maps_[index];
      map.distance_m.resize(pixels_);
      map.confidence.resize(pixels_);
      hdf5_.read_slab("distance_m", index, ElementType::kFloat32,
                      std::as_writable_bytes(std::span(map.distance_m)));
      hdf5_.read_slab("confidence", index, ElementType::kUint8,
                      std::as_writable_bytes(std::span(map.confidence)));
    });
    return maps_[index];
  }

 private:
  Hdf5File hdf5_;
  std::size_t pixels_;
  std::vector<std::once_flag> decoded_;
  std::vector<Map> maps_;
};

DistanceVolume DistanceVolume::open(const fs::path& file, const Line& line) {
  Hdf5File hdf5 = Hdf5File::open(file);
  hdf5.require_format(kDistanceVolumeFormat);
  check_line(hdf5, line);
  DistanceVolume volume;
  volume.stations_ = hdf5.read<std::int32_t>("station");
  check_stations(volume.stations_, line, file.string());
  volume.stored_.resize(volume.stations_.size());
  std::iota(volume.stored_.begin(), volume.stored_.end(), 0);
  volume.origin_ = hdf5.text_attribute("origin").value_or(kGivenOrigin);
  std::vector<std::int32_t> left_out;
  if (hdf5.has_dataset("left_out")) left_out = hdf5.read<std::int32_t>("left_out");
  std::vector<std::string> map_sha256;
  if (hdf5.has_dataset("sha256")) map_sha256 = hdf5.read_strings("sha256");
  if (volume.maps() > 0) volume.size_ = size_of_maps(hdf5, volume.stations_.size());
  const auto header_sha256 = hdf5.text_attribute("header_sha256");
  if (!header_sha256 && map_sha256.empty()) map_sha256 = {stamp_of(file).text()};
  volume.header_sha256_ = sha256_of(DistanceHeader{.line = line.id,
                                                   .origin = volume.origin_,
                                                   .size = volume.size_,
                                                   .stations = volume.stations_,
                                                   .map_sha256 = map_sha256,
                                                   .left_out = left_out});
  if (header_sha256 && *header_sha256 != volume.header_sha256_) {
    throw Error(file.string() + ": damaged: its header does not match its checksum");
  }
  if (!left_out.empty()) {
    volume.left_out_ = LeftOutPixels(left_out, volume.size_, static_cast<int>(line.stations.size()),
                                     file.string());
  }
  if (volume.maps() == 0) return volume;
  if (hdf5.chunk_of("distance_m")) {
    volume.deflated_ =
        std::make_shared<DeflatedMaps>(std::move(hdf5), volume.stations_.size(), volume.size_);
    return volume;
  }
  const auto distance_m =
      std::make_shared<MappedDataset>(hdf5, "distance_m", ElementType::kFloat32);
  const auto confidence = std::make_shared<MappedDataset>(hdf5, "confidence", ElementType::kUint8);
  volume.distance_m_ = {distance_m, static_cast<const float*>(distance_m->data())};
  volume.confidence_ = {confidence, static_cast<const std::uint8_t*>(confidence->data())};
  return volume;
}

const DistanceVolume::Map& DistanceVolume::decoded(int map) const {
  return deflated_->map(static_cast<std::size_t>(stored_[static_cast<std::size_t>(map)]));
}

DistanceVolume DistanceVolume::subset(std::span<const int> stations_of_line) const {
  DistanceVolume part = *this;
  part.stations_.clear();
  part.stored_.clear();
  for (size_t station = 0; station < stations_of_line.size(); ++station) {
    const auto found = std::ranges::lower_bound(stations_, stations_of_line[station]);
    if (found == stations_.end() || *found != stations_of_line[station]) continue;
    part.stations_.push_back(static_cast<int>(station));
    part.stored_.push_back(stored_[static_cast<size_t>(found - stations_.begin())]);
  }
  part.left_out_ = left_out_.subset(stations_of_line);
  return part;
}

std::vector<DistanceVolume> open_distance_volumes(const fs::path& folder, const Grid& grid) {
  std::vector<DistanceVolume> volumes;
  for (const Line& line : grid.lines) {
    volumes.push_back(DistanceVolume::open(folder / (line.id + ".h5"), line));
  }
  return volumes;
}

std::string origin_of(std::span<const DistanceVolume> volumes) {
  std::vector<std::string> origins;
  for (const DistanceVolume& volume : volumes) {
    if (volume.maps() > 0 && std::ranges::find(origins, volume.origin()) == origins.end()) {
      origins.push_back(volume.origin());
    }
  }
  return origins.empty() ? "none" : fmt::format("{}", fmt::join(origins, " and "));
}

}  // namespace raywalk
