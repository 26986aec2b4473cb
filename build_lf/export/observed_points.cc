#include "build_lf/export/observed_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>

#include "build_lf/export/station_surface.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk::build_lf {
namespace {

constexpr std::size_t kMostAsked = 12;
constexpr std::size_t kMostObservers = 8;
constexpr double kHuge = std::numeric_limits<double>::infinity();

// A station with a distance map.
struct MappedStation {
  int exported = 0;  // index
  StationSurface surface;
};

std::vector<MappedStation> mapped_stations(const Room& room,
                                           const std::vector<ExportedStation>& stations,
                                           double max_distance_m) {
  std::vector<MappedStation> mapped;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const StationIndex index = stations[i].index;
    const auto map = room.distances(index.line).map_of(index.station);
    if (!map) continue;
    mapped.push_back({static_cast<int>(i), StationSurface(room, index, *map, max_distance_m)});
  }
  return mapped;
}

// Indices of the others, nearest first.
std::vector<std::size_t> nearest_others(const std::vector<MappedStation>& stations,
                                        std::size_t of) {
  std::vector<std::size_t> others(stations.size());
  std::iota(others.begin(), others.end(), std::size_t{0});
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(of));
  const auto distance = [&](std::size_t i) {
    return (stations[i].surface.position_m() - stations[of].surface.position_m()).squaredNorm();
  };
  std::stable_sort(others.begin(), others.end(),
                   [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  others.resize(std::min(others.size(), kMostAsked));
  return others;
}

// The i-th of `count` directions evenly over the sphere: a spiral that turns by the golden angle
// (Gonzalez 2010, "Measurement of areas on a sphere using Fibonacci and latitude-longitude
// lattices"), begun at another longitude by every station.
Eigen::Vector3d spiral_direction(int i, int count, std::size_t station) {
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  const double sine = 1.0 - 2.0 * (i + 0.5) / count;
  return direction_from_angles(
      {wrap_angle(golden * (i + 0.37 * static_cast<double>(station))), std::asin(sine)});
}

// The face of a cube that sees a direction.
int face_towards(const std::vector<PanoramaFace>& faces, const Eigen::Vector3d& direction) {
  int best = 0;
  double largest = -1.0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double along = faces[i].camera_from_face.col(2).dot(direction);
    if (along <= largest) continue;
    largest = along;
    best = static_cast<int>(i);
  }
  return best;
}

class PointSampler {
 public:
  PointSampler(const Room& room, const std::vector<ExportedStation>& stations,
               const PointSearch& search)
      : room_(room),
        exported_(stations),
        search_(search),
        faces_(cube_faces()),
        stations_(mapped_stations(room, stations, search.max_distance_m)) {}

  std::vector<ObservedPoint> sample() const {
    std::vector<std::vector<ObservedPoint>> points(stations_.size());
    Progress progress("Collecting points", static_cast<std::int64_t>(stations_.size()), "maps");
    parallel_for(0, static_cast<int>(stations_.size()), 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const auto station = static_cast<std::size_t>(i);
        points[station] = points_of(station);
        progress.advance();
      }
    });
    std::vector<ObservedPoint> all;
    for (std::vector<ObservedPoint>& of_station : points) {
      std::move(of_station.begin(), of_station.end(), std::back_inserter(all));
    }
    return all;
  }

 private:
  std::vector<ObservedPoint> points_of(std::size_t station) const {
    const MappedStation& own = stations_[station];
    const ExportedStation& exported = exported_[static_cast<std::size_t>(own.exported)];
    const cv::Mat columns = station_columns(room_, exported.index, search_.gains);
    const std::vector<std::size_t> others = nearest_others(stations_, station);
    const auto tried_before = [&](std::size_t stations) {
      return static_cast<std::size_t>(search_.points) * stations / stations_.size();
    };
    const auto count = static_cast<int>(tried_before(station + 1) - tried_before(station));
    std::vector<ObservedPoint> points;
    for (int i = 0; i < count; ++i) {
      auto point = point_near(own, spiral_direction(i, count, station));
      if (!point) continue;
      add_observers(others, &*point);
      if (point->observations.size() < 2) continue;
      point->colour = colour_at(columns, point->position_m - own.surface.position_m());
      points.push_back(std::move(*point));
    }
    return points;
  }

  std::optional<ObservedPoint> point_near(const MappedStation& own,
                                          const Eigen::Vector3d& direction) const {
    const PanoramaSize size = own.surface.size();
    const PixelsAround pixels =
        pixels_around(pixel_from_angles(angles_from_direction(direction), size), size);
    const auto position = own.surface.point_m(pixels.nearest_column(), pixels.nearest_row());
    if (!position) return std::nullopt;
    ObservedPoint point{.position_m = *position};
    point.observations.push_back(observation(own, *position, *position));
    return point;
  }

  // Of a point that the station shows at `seen_m`.
  PointObservation observation(const MappedStation& station, const Eigen::Vector3d& seen_m,
                               const Eigen::Vector3d& point_m) const {
    const Eigen::Vector3d seen = seen_m - station.surface.position_m();
    const int face = face_towards(faces_, seen);
    const PanoramaFace& of = faces_[static_cast<std::size_t>(face)];
    const auto pixel = face_pixel_of(of, search_.face_px, seen);
    const auto truth = face_pixel_of(of, search_.face_px, point_m - station.surface.position_m());
    if (!pixel || !truth) return {station.exported, face, {}, kHuge};
    return {station.exported, face, *pixel, std::hypot(pixel->x - truth->x, pixel->y - truth->y)};
  }

  void add_observers(const std::vector<std::size_t>& others, ObservedPoint* point) const {
    for (const std::size_t other : others) {
      if (point->observations.size() == kMostObservers) return;
      const auto seen_m = stations_[other].surface.nearest_point_m(point->position_m);
      if (!seen_m) continue;
      const PointObservation seen = observation(stations_[other], *seen_m, point->position_m);
      if (seen.error_px < search_.most_error_px) point->observations.push_back(seen);
    }
  }

  const Room& room_;
  const std::vector<ExportedStation>& exported_;
  PointSearch search_;
  std::vector<PanoramaFace> faces_;
  std::vector<MappedStation> stations_;
};

}  // namespace

std::vector<ObservedPoint> observed_points(const Room& room,
                                           const std::vector<ExportedStation>& stations,
                                           const PointSearch& search) {
  return PointSampler(room, stations, search).sample();
}

}  // namespace raywalk::build_lf
