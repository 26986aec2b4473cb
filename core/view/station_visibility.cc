#include "core/view/station_visibility.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/fast_math.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// A surface hides a point only if seen from the viewpoint both would move by at least this much
// against each other, in pixels of the maps: less is noise, and would not be painted wrongly.
constexpr double kClearlyNearerPx = 2.0;

// About this many rows are looked up first, 1.4 degrees apart: what is so near that it hides
// something else from a line only is larger.
constexpr int kCoarseRows = 128;
constexpr int kMaxStep = 16;

// The maps at or before a station and at or after it, as indices; twice the same at the ends.
std::array<int, 2> maps_around(const DistanceVolume& volume, int station) {
  const auto stations = volume.stations();
  const auto last = static_cast<int>(stations.size()) - 1;
  const auto after =
      static_cast<int>(std::ranges::lower_bound(stations, station) - stations.begin());
  if (after > last) return {last, last};
  if (stations[static_cast<size_t>(after)] == station || after == 0) return {after, after};
  return {after - 1, after};
}

}  // namespace

// One map looked up along one column.
struct StationVisibility::Lookup {
  Lookup(const Room& room, int line, int map, const EyeCircle& eye, const DistanceView& distances,
         int column)
      : theta(column),
        omega(distances.column(column)),
        nearer(1.0f + distances.surface_tolerance()) {
    const DistanceVolume& volume = room.distances(line);
    const int station = volume.stations()[static_cast<size_t>(map)];
    const Eigen::Vector3d& station_m = room.grid()
                                           .lines[static_cast<size_t>(line)]
                                           .stations[static_cast<size_t>(station)]
                                           .position_m;
    const PanoramaSize size = volume.size();
    theta_rad = angles_from_pixel({double(column), 0.0}, distances.size()).theta_rad;
    const Eigen::Vector3d eye_m = eye.position_m(theta_rad);
    const Eigen::Vector3d displacement_m = eye_m - station_m;
    from_centre_m = (eye_m - eye.centre_m).cast<float>();
    const ColumnPosition position =
        split_column(pixel_from_angles({theta_rad, 0.0}, size).u, size.width);
    from_station_m = displacement_m.cast<float>();
    offset = column_offset(displacement_m, theta_rad);
    target = {size.width, size.height, position.whole, position.part};
    distance_m = volume.distance_column(map, 0).data();
    confidence = volume.confidence_column(map, 0).data();
    slack_per_m = static_cast<float>(kClearlyNearerPx * kTwoPi / size.width /
                                     std::max(1e-9, displacement_m.norm()));
  }

  // Whether the map holds at `pixel` a surface clearly nearer than a point at `omega_there`.
  bool hides(std::int32_t pixel, float omega_there) const {
    const float held_m = distance_m[pixel];
    return (held_m * (omega_there * nearer + slack_per_m) < 1.0f) & (held_m > 0.0f) &
           (confidence[pixel] >= kMinConfidence);
  }

  int theta = 0;
  double theta_rad = 0.0;
  const float* omega = nullptr;  // of the column, from its eye
  float nearer = 1.0f;
  float slack_per_m = 0.0f;
  Eigen::Vector3f from_station_m{0, 0, 0};  // to the column's eye
  Eigen::Vector3f from_centre_m{0, 0, 0};   // of the eyes' circle to the column's eye
  ColumnOffset offset;
  ColumnTarget target;
  const float* distance_m = nullptr;  // of the map, [column][row]
  const std::uint8_t* confidence = nullptr;
};

StationVisibility::StationVisibility(const Room& room, const DistanceView& distances,
                                     const EyeCircle& eye)
    : room_(room),
      distances_(distances),
      eye_(eye),
      latitudes_(distances.size().height, distances.size().height),
      step_(std::clamp(distances.size().height / kCoarseRows, 1, kMaxStep)),
      omega_there_(static_cast<size_t>(distances.size().height)),
      left_(omega_there_.size()),
      right_(omega_there_.size()) {
  for (int row = 0; row < distances.size().height; row += step_) {
    coarse_sin_phi_.push_back(*latitudes_.table(row).sin_phi);
    coarse_cos_phi_.push_back(*latitudes_.table(row).cos_phi);
  }
  coarse_omega_.resize(coarse_sin_phi_.size());
}

void StationVisibility::remove_hidden(const StationPair& stations, int theta,
                                      std::span<std::uint8_t> visible) {
  const DistanceVolume& volume = room_.distances(stations.line);
  if (volume.maps() == 0) return;
  known_count_ = 0;
  for (int next = 0; next < 2; ++next) {
    if (!stations.read[static_cast<size_t>(next)]) continue;
    const auto [before, after] = maps_around(volume, stations.first + next);
    const auto& first = hidden_in(stations.line, before, theta, visible);
    const auto& second = hidden_in(stations.line, after, theta, visible);
    // Branchless, so that the compiler vectorises it.
    for (size_t row = 0; row < visible.size(); ++row) {
      visible[row] = static_cast<std::uint8_t>(visible[row] & ~(first[row] & second[row]));
    }
  }
}

const std::vector<std::uint8_t>& StationVisibility::hidden_in(
    int line, int map, int theta, std::span<const std::uint8_t> visible) {
  for (size_t i = 0; i < known_count_; ++i) {
    if (known_[i].map == map) return known_[i].hidden;
  }
  MapRows& rows = known_[known_count_++];
  rows.map = map;
  rows.hidden.assign(visible.size(), 0);
  const Lookup lookup(room_, line, map, eye_, distances_, theta);
  find_suspects(lookup);
  const auto begin = suspect_.begin();
  for (auto first = std::find(begin, suspect_.end(), 1); first != suspect_.end();) {
    const auto end = std::find(first, suspect_.end(), 0);
    check_rows(lookup, static_cast<int>(first - begin), static_cast<int>(end - begin), visible,
               &rows.hidden);
    first = std::find(end, suspect_.end(), 1);
  }
  return rows.hidden;
}

void StationVisibility::find_suspects(const Lookup& lookup) {
  const int rows = distances_.size().height;
  suspect_.assign(static_cast<size_t>(rows), 0);
  for (size_t i = 0; i < coarse_omega_.size(); ++i) {
    coarse_omega_[i] = lookup.omega[i * static_cast<size_t>(step_)];
  }
  column_kernels().look_up_points({coarse_sin_phi_.data(), coarse_cos_phi_.data()},
                                  coarse_omega_.data(), static_cast<int>(coarse_omega_.size()),
                                  lookup.offset, lookup.target, omega_there_.data(), left_.data(),
                                  right_.data());
  for (size_t i = 0; i < coarse_omega_.size(); ++i) {
    if (!lookup.hides(left_[i], omega_there_[i])) continue;
    const int row = static_cast<int>(i) * step_;
    std::fill(suspect_.begin() + std::max(row - step_ + 1, 0),
              suspect_.begin() + std::min(row + step_, rows), std::uint8_t{1});
  }
}

void StationVisibility::check_rows(const Lookup& lookup, int first, int end,
                                   std::span<const std::uint8_t> visible,
                                   std::vector<std::uint8_t>* hidden) {
  const RowTable table = latitudes_.table(first);
  column_kernels().look_up_points(table, lookup.omega + first, end - first, lookup.offset,
                                  lookup.target, omega_there_.data(), left_.data(), right_.data());
  const auto forward = static_cast<float>(std::cos(lookup.theta_rad));
  const auto aside = static_cast<float>(std::sin(lookup.theta_rad));
  for (int row = first; row < end; ++row) {
    if (visible[static_cast<size_t>(row)] == 0) continue;
    const auto i = static_cast<size_t>(row - first);
    // The nearest of the four pixels around that hides the point. One is enough: what a camera
    // captures at a silhouette is in part the foreground, and painted onto the background it would
    // draw the outline once more.
    std::int32_t nearest = -1;
    for (const std::int32_t pixel : {left_[i], left_[i] + 1, right_[i], right_[i] + 1}) {
      if (!lookup.hides(pixel, omega_there_[i])) continue;
      if (nearest < 0 || lookup.distance_m[pixel] < lookup.distance_m[nearest]) nearest = pixel;
    }
    if (nearest < 0) continue;
    if (between_nearer(lookup.theta, row)) continue;
    const Eigen::Vector3f direction(table.cos_phi[i] * aside, table.sin_phi[i],
                                    table.cos_phi[i] * forward);
    const Eigen::Vector3f seen = direction + lookup.omega[row] * lookup.from_station_m;
    const Eigen::Vector3f occluder_m =
        lookup.distance_m[nearest] * seen.normalized() - lookup.from_station_m;
    (*hidden)[static_cast<size_t>(row)] = viewpoint_agrees(lookup, occluder_m) ? 1 : 0;
  }
}

// Whether the distances of a column have a crack here: both neighbours in the row, or both in the
// column, are clearly nearer. The viewpoint then sees them, whatever the distance says.
bool StationVisibility::between_nearer(int theta, int row) const {
  const PanoramaSize size = distances_.size();
  const auto omega = [&](int u, int v) {
    return distances_.column(wrapped_column(u, size.width))[v];
  };
  const float nearer = omega(theta, row) * (1.0f + distances_.surface_tolerance());
  if (std::min(omega(theta - 1, row), omega(theta + 1, row)) > nearer) return true;
  return row > 0 && row + 1 < size.height &&
         std::min(omega(theta, row - 1), omega(theta, row + 1)) > nearer;
}

// Whether the view shows the occluder, at `occluder_m` from the column's eye, or something nearer.
// If it shows what is behind the occluder, one of the maps is wrong.
bool StationVisibility::viewpoint_agrees(const Lookup& lookup,
                                         const Eigen::Vector3f& occluder_m) const {
  const PanoramaSize size = distances_.size();
  const auto radius = static_cast<float>(eye_.radius_m);
  // As EyeCircle::direction_of() has it. What is inside the circle, no eye of it sees.
  const Eigen::Vector3f occluder = occluder_m + lookup.from_centre_m;
  const float plan_squared = occluder.x() * occluder.x() + occluder.z() * occluder.z();
  if (plan_squared < radius * radius) return true;
  const float plan = std::sqrt(plan_squared - radius * radius);
  const float turn = radius == 0.0f ? 0.0f : fast_atan2(radius, plan) / float(kTwoPi);
  const int u =
      static_cast<int>((fast_atan2(occluder.x(), occluder.z()) / float(kTwoPi) + turn + 0.5f) *
                       static_cast<float>(size.width));
  const int v = static_cast<int>((0.5f - fast_atan2(occluder.y(), plan) / float(kPi)) *
                                 static_cast<float>(size.height));
  float nearest = 0.0f;
  for (int column = u - 1; column <= u + 1; ++column) {
    const float* const omega = distances_.column(wrapped_column(column, size.width));
    for (int row = std::max(v - 1, 0); row <= std::min(v + 1, size.height - 1); ++row) {
      nearest = std::max(nearest, omega[row]);
    }
  }
  const float expected = 1.0f / std::max(1e-9f, occluder_m.norm());
  return nearest >= expected * (1.0f - distances_.surface_tolerance()) - lookup.slack_per_m;
}

}  // namespace raywalk
