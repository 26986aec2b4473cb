#include "build_lf/pack/derived_volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/room/distance_maps.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

void copy_volume(const fs::path& from, const fs::path& to) {
  AtomicFile output(to);
  std::error_code error;
  fs::copy_file(from, output.temporary_path(), fs::copy_options::overwrite_existing, error);
  if (error) {
    throw Error(
        fmt::format("{}: cannot be copied to {}: {}", from.string(), to.string(), error.message()));
  }
  output.commit();
}

void advance(std::int64_t images, Progress* progress) {
  for (std::int64_t i = 0; i < images; ++i) progress->advance();
}

// A map at another width: inverse distances interpolated as in OmegaMap, confidence of the nearest
// pixel.
StationDistances reduced_distances(const DistanceVolume& volume, int map, int width) {
  const OmegaMap omega = resized(omega_map_of(volume, map), width);
  const double scale = static_cast<double>(volume.size().width) / width;
  StationDistances distances;
  for (int theta = 0; theta < width; ++theta) {
    const auto confidence = volume.confidence_column(map, static_cast<int>((theta + 0.5) * scale));
    for (int row = 0; row < width / 2; ++row) {
      const float known = omega.at(theta, row);
      const auto from = static_cast<size_t>((row + 0.5) * scale);
      distances.distance_m.push_back(known < 0.0f ? 0.0f : 1.0f / known);
      distances.confidence.push_back(known < 0.0f ? std::uint8_t{0} : confidence[from]);
    }
  }
  distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
  return distances;
}

}  // namespace

std::int64_t images_of(const Room& room) {
  std::int64_t images = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    images += room.volume(line).stations() + room.distances(line).maps();
  }
  return images;
}

void write_derived_rays(const Room& room, const Room& part, int index, const RayForm& form,
                        const fs::path& out, Progress* progress) {
  throw_if_interrupted();
  const Line& line = part.grid().lines[static_cast<std::size_t>(index)];
  const LineVolume& rays = part.volume(index);
  const fs::path file = line_volume_path(out, line.id);
  const bool is_same = rays.form() == form && rays.stations() == room.volume(index).stations();
  if (fs::exists(file)) return advance(rays.stations(), progress);
  if (is_same && form.kind == RayForm::Kind::kJpeg) {
    copy_volume(line_volume_path(room.directory(), line.id), file);
    return advance(rays.stations(), progress);
  }
  write_line_volume(file, line,
                    {.panorama = part.panorama(),
                     .masked = rays.masked(),
                     .read = [&](size_t i) { return stored_rays(rays, static_cast<int>(i)); },
                     .form = form},
                    progress);
}

void write_derived_maps(const DistanceVolume& maps, const Line& line, DistanceKind kind,
                        int most_width, bool compressed, const fs::path& out, Progress* progress) {
  throw_if_interrupted();
  const fs::path file = distance_volume_path(out, line.id, kind);
  if (fs::exists(file)) return advance(maps.maps(), progress);
  const int width = std::min(most_width, maps.size().width);
  const auto read = [&](size_t i) {
    return width < maps.size().width ? reduced_distances(maps, static_cast<int>(i), width)
                                     : stored_distances(maps, static_cast<int>(i));
  };
  write_distance_volume(file, line,
                        {.stations = {maps.stations().begin(), maps.stations().end()},
                         .size = {width, width / 2},
                         .origin = maps.origin(),
                         .read = read,
                         .compressed = compressed,
                         .left_out = maps.left_out().stored_runs({width, width / 2})},
                        progress);
}

}  // namespace raywalk::build_lf
