#include "build_lf/require/omega_map.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"

namespace raywalk::build_lf {
namespace {

bool same_surface(float a, float b, float tolerance) {
  return std::abs(a - b) <= tolerance * std::max(a, b);
}

// Splats a point of a map into the pixels it covers in the target, with a depth test.
class Splat {
 public:
  Splat(OmegaMap* target, PanoramaSize source)
      : target_(target), scale_(static_cast<double>(target->size().width) / source.width) {}

  // A source pixel at latitude `phi_rad` spans cos(phi) of a pixel's angle along its row; in the
  // target it is larger by the ratio of the distances.
  void write(const SeenPoint& seen, double phi_rad, double magnification) {
    const PanoramaSize size = target_->size();
    const PixelPosition at = pixel_from_angles(seen.angles, size);
    const double half_rows = 0.5 * scale_ * std::min(magnification, kMaxMagnification);
    const double widening =
        std::cos(phi_rad) / std::max(std::cos(seen.angles.phi_rad), 1.0 / size.width);
    const double half_columns = std::min(half_rows * widening, 0.5 * size.width - 1.0);
    const int first_row = std::max(0, static_cast<int>(std::floor(at.v - half_rows + 0.5)));
    const int last_row =
        std::min(size.height - 1, static_cast<int>(std::ceil(at.v + half_rows - 0.5)));
    const int first_column = static_cast<int>(std::floor(at.u - half_columns + 0.5));
    const int last_column = static_cast<int>(std::ceil(at.u + half_columns - 0.5));
    for (int column = first_column; column <= last_column; ++column) {
      const int theta = wrapped_column(column, size.width);
      for (int row = first_row; row <= last_row; ++row) {
        float& omega = target_->at(theta, row);
        omega = std::max(omega, seen.omega);
      }
    }
  }

 private:
  // A surface far from the source but close to the target is too coarse to be useful.
  static constexpr double kMaxMagnification = 4.0;

  OmegaMap* target_;
  double scale_;  // target pixels per source pixel
};

Eigen::Vector3d direction_at(int theta, int row, PanoramaSize size) {
  return direction_from_angles(
      angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size));
}

void project(const PlacedMap& from, const Eigen::Vector3d& position_m, OmegaMap* target) {
  const PanoramaSize size = from.map->size();
  const Eigen::Vector3d offset_m = from.position_m - position_m;
  Splat splat(target, size);
  for (int theta = 0; theta < size.width; ++theta) {
    for (int row = 0; row < size.height; ++row) {
      const float omega = from.map->at(theta, row);
      if (omega < 0.0f) continue;
      const SeenPoint seen = seen_from(direction_at(theta, row, size), omega, offset_m);
      const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, size).phi_rad;
      splat.write(seen, phi_rad, omega > 0.0f ? seen.omega / omega : 1.0);
    }
  }
}

// The inverse distance, seen from the target, of the map's surface point closest to the point at
// `direction` and approximately `omega`. None if the map sees another surface there.
std::optional<float> looked_up(const PlacedMap& in, const Eigen::Vector3d& direction, float omega,
                               const Eigen::Vector3d& position_m) {
  const Eigen::Vector3d offset_m = position_m - in.position_m;
  const SeenPoint there = seen_from(direction, omega, offset_m);
  const float known = in.map->sample(pixel_from_angles(there.angles, in.map->size()));
  // Projected values are themselves off by up to the change across one pixel.
  if (known < 0.0f || !same_surface(known, there.omega, 2.0f * in.map->surface_tolerance())) {
    return std::nullopt;
  }
  return seen_from(direction_from_angles(there.angles), known, -offset_m).omega;
}

// Intersects the ray in `direction` with the map's surface by fixed-point iteration: the map's
// surface point is off the ray by the error of `omega` times the parallax between the two
// positions, so each lookup reduces the error.
std::optional<float> intersected(const PlacedMap& in, const Eigen::Vector3d& direction, float omega,
                                 const Eigen::Vector3d& position_m) {
  constexpr int kMaxIterations = 4;
  constexpr float kConverged = 1e-4f;
  std::optional<float> found = looked_up(in, direction, omega, position_m);
  for (int iteration = 1; iteration < kMaxIterations && found; ++iteration) {
    const float before = *found;
    found = looked_up(in, direction, before, position_m);
    if (found && same_surface(*found, before, kConverged)) break;
  }
  return found;
}

void refine(std::span<const PlacedMap> maps, const Eigen::Vector3d& position_m, OmegaMap* target) {
  const PanoramaSize size = target->size();
  for (int theta = 0; theta < size.width; ++theta) {
    for (int row = 0; row < size.height; ++row) {
      float& omega = target->at(theta, row);
      if (omega <= 0.0f) continue;
      const Eigen::Vector3d direction = direction_at(theta, row, size);
      for (const PlacedMap& map : maps) {
        if (const auto found = intersected(map, direction, omega, position_m)) {
          omega = *found;
          break;
        }
      }
    }
  }
}

// Fills each run of unknown pixels of a row (cyclic) with the farther of its ends.
void fill_row(int row, OmegaMap* map) {
  const int width = map->size().width;
  int known = 0;
  while (known < width && map->at(known, row) < 0.0f) ++known;
  if (known == width) return;
  int last = known;  // last known pixel; no gap from `known` up to it
  for (int step = 1; step <= width; ++step) {
    const int here = known + step;
    const float omega = map->at(wrapped_column(here, width), row);
    if (omega < 0.0f) continue;
    const float farther = std::min(omega, map->at(wrapped_column(last, width), row));
    for (int gap = last + 1; gap < here; ++gap) map->at(wrapped_column(gap, width), row) = farther;
    last = here;
  }
}

}  // namespace

float OmegaMap::surface_tolerance() const {
  static const double slope = std::tan(radians_from_degrees(80.0));
  return static_cast<float>(slope * kTwoPi / size_.width);
}

float OmegaMap::sample(PixelPosition pixel) const {
  const PixelsAround around = pixels_around(pixel, size_);
  const float nearest = at(around.nearest_column(), around.nearest_row());
  if (nearest < 0.0f) return nearest;
  const float tolerance = surface_tolerance();
  double sum = 0.0, weight = 0.0;
  for (size_t i = 0; i < 2; ++i) {
    for (size_t j = 0; j < 2; ++j) {
      const float omega = at(around.column[i], around.row[j]);
      if (omega < 0.0f || !same_surface(omega, nearest, tolerance)) continue;
      sum += around.weight(i, j) * omega;
      weight += around.weight(i, j);
    }
  }
  return static_cast<float>(sum / weight);
}

OmegaMap omega_map_of(const DistanceVolume& volume, int map) {
  OmegaMap result(volume.size());
  for (int theta = 0; theta < volume.size().width; ++theta) {
    const auto distances_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (int row = 0; row < volume.size().height; ++row) {
      const auto i = static_cast<size_t>(row);
      if (confidence[i] == 0 || !(distances_m[i] > 0.0f)) continue;
      const float omega = 1.0f / distances_m[i];
      if (std::isfinite(omega)) result.at(theta, row) = omega;
    }
  }
  return result;
}

OmegaMap resized(const OmegaMap& map, int width) {
  OmegaMap result({width, width / 2});
  const double scale = static_cast<double>(map.size().width) / width;
  for (int theta = 0; theta < width; ++theta) {
    for (int row = 0; row < width / 2; ++row) {
      result.at(theta, row) = map.sample({(theta + 0.5) * scale - 0.5, (row + 0.5) * scale - 0.5});
    }
  }
  return result;
}

// The point is at offset + direction / omega. Multiplied by omega this also holds for infinite
// distances: direction omega offset + direction, inverse distance omega / |omega offset +
// direction|.
SeenPoint seen_from(const Eigen::Vector3d& direction, float omega,
                    const Eigen::Vector3d& offset_m) {
  const Eigen::Vector3d towards = direction + static_cast<double>(omega) * offset_m;
  const double length = towards.norm();
  if (length == 0.0) return {angles_from_direction(direction), omega};  // here, in any direction
  return {angles_from_direction(towards), static_cast<float>(omega / length)};
}

OmegaMap projected(std::span<const PlacedMap> maps, const Eigen::Vector3d& position_m, int width) {
  OmegaMap result({width, width / 2});
  for (const PlacedMap& map : maps) project(map, position_m, &result);
  refine(maps, position_m, &result);
  for (int row = 0; row < result.size().height; ++row) fill_row(row, &result);
  return result;
}

}  // namespace raywalk::build_lf
