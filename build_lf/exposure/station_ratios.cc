#include "build_lf/exposure/station_ratios.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <type_traits>
#include <utility>

#include "build_lf/depth/nearest_maps.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

static_assert(std::is_trivially_copyable_v<PatchRatio>);

const Eigen::Vector3d& position_of(const Room& room, StationIndex station) {
  const Line& line = room.grid().lines[static_cast<size_t>(station.line)];
  return line.stations[static_cast<size_t>(station.station)].position_m;
}

NearestMaps places_of(const Room& room, const SurfaceMaps& maps) {
  std::vector<MapPlace> places;
  for (const StationIndex station : maps.stations) {
    places.push_back({station, position_of(room, station)});
  }
  return NearestMaps(std::move(places));
}

// Pictures and maps of the stations that a run of consecutive stations is compared with; these are
// mostly the same.
class Surfaces {
 public:
  Surfaces(const Room& room, const SurfaceMaps& maps) : room_(room), maps_(maps) {}

  const SurfacePicture& picture(StationIndex station) {
    const auto found = pictures_.find(station);
    if (found != pictures_.end()) return found->second;
    return pictures_.emplace(station, surface_picture(room_, station, maps_.size, maps_.valid))
        .first->second;
  }

  // Null if the station has none.
  const InverseDistanceMap* map(StationIndex station) {
    const auto found = read_.find(station);
    if (found != read_.end()) return &found->second;
    if (!std::binary_search(maps_.stations.begin(), maps_.stations.end(), station)) return nullptr;
    return &read_.emplace(station, maps_.read(station)).first->second;
  }

 private:
  const Room& room_;
  const SurfaceMaps& maps_;
  std::map<StationIndex, SurfacePicture> pictures_;
  std::map<StationIndex, InverseDistanceMap> read_;
};

WholeRatio whole_ratio(const StationRatios& ratios) {
  constexpr double kModelError = 0.005;
  WholeRatio whole{ratios.from, ratios.to, {}, !ratios.patches.empty()};
  if (!whole.known) return whole;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const PatchRatio& patch : ratios.patches) {
      values.push_back(static_cast<double>(patch.log_ratio[c]));
    }
    const double middle = median(values);
    const auto count = static_cast<double>(values.size());
    for (double& value : values) value = std::fabs(value - middle);
    const double error = robust_sigma(std::move(values)) / std::sqrt(count);
    whole.channels[c] = {ratios.from, ratios.to, middle, std::hypot(error, kModelError)};
  }
  return whole;
}

}  // namespace

RatioFile::RatioFile(const std::filesystem::path& directory, std::size_t stations)
    : directory_(directory), file_(directory), stations_(stations) {}

void RatioFile::put(int to, std::span<const StationRatios> ratios) {
  Station& station = stations_[static_cast<size_t>(to)];
  std::vector<PatchRatio> patches;
  for (const StationRatios& pair : ratios) {
    station.pairs.push_back({pair.from, pair.patches.size()});
    patches.insert(patches.end(), pair.patches.begin(), pair.patches.end());
  }
  const std::size_t bytes = patches.size() * sizeof(PatchRatio);
  {
    const std::lock_guard lock(mutex_);
    station.offset = size_;
    size_ += bytes;
  }
  const char* data = reinterpret_cast<const char*>(patches.data());
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t wrote = ::pwrite(file_.descriptor(), data + done, bytes - done,
                                   static_cast<off_t>(station.offset + done));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) {
      throw Error(directory_.string() +
                  ": the ratios of stations cannot be kept there: " + std::strerror(errno));
    }
    done += static_cast<std::size_t>(wrote);
  }
}

std::vector<StationRatios> RatioFile::get(int to) const {
  const Station& station = stations_[static_cast<size_t>(to)];
  std::vector<StationRatios> ratios;
  std::size_t at = station.offset;
  for (const Place& pair : station.pairs) {
    StationRatios& read = ratios.emplace_back();
    read.from = pair.from;
    read.to = to;
    read.patches.resize(pair.patches);
    const std::size_t bytes = pair.patches * sizeof(PatchRatio);
    char* data = reinterpret_cast<char*>(read.patches.data());
    for (std::size_t done = 0; done < bytes;) {
      const ssize_t got =
          ::pread(file_.descriptor(), data + done, bytes - done, static_cast<off_t>(at + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) throw Error(directory_.string() + ": the ratios of stations cannot be read");
      done += static_cast<std::size_t>(got);
    }
    at += bytes;
  }
  return ratios;
}

std::vector<WholeRatio> measure_ratios(const Room& room, std::span<const StationIndex> stations,
                                       const SurfaceMaps& maps, RatioFile* file) {
  constexpr size_t kOwn = 4;
  constexpr size_t kOthers = 6;
  std::map<StationIndex, int> number;
  for (const StationIndex station : stations) {
    number.emplace(station, static_cast<int>(number.size()));
  }
  const NearestMaps nearest = places_of(room, maps);
  std::vector<std::vector<WholeRatio>> of_station(stations.size());
  Progress progress("comparing surfaces", std::ssize(stations), "stations");
  constexpr int kStationsPerTask = 8;
  parallel_for(0, static_cast<int>(stations.size()), kStationsPerTask, [&](int begin, int end) {
    Surfaces surfaces(room, maps);
    for (int i = begin; i < end; ++i) {
      const StationIndex to = stations[static_cast<size_t>(i)];
      std::vector<StationRatios> ratios;
      for (const int partner : nearest.around(to, position_of(room, to), kOwn, kOthers)) {
        const StationIndex from = maps.stations[static_cast<size_t>(partner)];
        const auto from_number = number.find(from);
        if (from_number == number.end()) continue;
        std::vector<PatchRatio> patches = compare_surfaces(
            surfaces.picture(from), *surfaces.map(from), surfaces.picture(to), surfaces.map(to));
        ratios.push_back({from_number->second, i, std::move(patches)});
      }
      std::ranges::transform(ratios, std::back_inserter(of_station[static_cast<size_t>(i)]),
                             whole_ratio);
      file->put(i, ratios);
      progress.advance();
    }
  });
  std::vector<WholeRatio> all;
  for (const std::vector<WholeRatio>& ratios : of_station)
    std::ranges::copy(ratios, std::back_inserter(all));
  return all;
}

}  // namespace raywalk::build_lf
