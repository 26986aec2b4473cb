#include "build_lf/require/thin_room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <span>

#include "build_lf/pack_room.h"
#include "build_lf/partial_room.h"
#include "build_lf/volume_writer.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/recreated_station.h"
#include "core/files/atomic_output.h"
#include "core/files/folder_size.h"
#include "core/files/sha256.h"
#include "core/room/omega_map.h"
#include "core/room/room_fingerprint.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxViews = 48;

// A map at another width: inverse distances interpolated as in OmegaMap, confidence of the nearest
// pixel.
StationDistances resized_distances(const DistanceVolume& volume, int map, int width) {
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
  return distances;
}

StationDistances distances_of(const DistanceVolume& volume, int map, int width) {
  const int own_width = volume.size().width;
  if (width >= own_width) return stored_distances(volume, map);
  StationDistances distances = resized_distances(volume, map, width);
  distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
  return distances;
}

// `part` is the room with only the kept stations.
void write_line(const Room& part, int index, DistanceKind kind, int distance_width,
                const fs::path& out, Progress* progress) {
  const Line& line = part.grid().lines[static_cast<size_t>(index)];
  const LineVolume& rays = part.volume(index);
  const fs::path rays_file = line_volume_path(out, line.id);
  if (!fs::exists(rays_file)) {
    write_line_volume(rays_file, line,
                      {.panorama = part.panorama(),
                       .masked = rays.masked(),
                       .read = [&](size_t i) { return stored_rays(rays, static_cast<int>(i)); },
                       .form = rays.form()},
                      progress);
  }
  const DistanceVolume& distances = part.distances(index);
  if (kind == DistanceKind::kNone) return;
  const fs::path distances_file = distance_volume_path(out, line.id, kind);
  if (fs::exists(distances_file)) return;
  const int width = std::min(distance_width, distances.size().width);
  write_distance_volume(
      distances_file, line,
      {.stations = {distances.stations().begin(), distances.stations().end()},
       .size = {width, width / 2},
       .origin = distances.origin(),
       .read = [&](size_t i) { return distances_of(distances, static_cast<int>(i), width); },
       .compressed = distances.compressed(),
       .left_out = distances.left_out().stored_runs({width, width / 2})},
      progress);
}

// Over everything that determines the result.
std::string fingerprint_of(const Room& room, const KeptStations& kept, int distance_width) {
  return sha256_hex(fmt::format("{}{} {}", room_fingerprint(room), kept, distance_width));
}

std::int64_t images_of(const Room& room) {
  std::int64_t images = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    images += room.volume(line).stations() + room.distances(line).maps();
  }
  return images;
}

std::vector<HeldOutStation> dropped_stations(const Grid& grid, const KeptStations& kept) {
  std::vector<HeldOutStation> dropped;
  for (int line = 0; line < static_cast<int>(kept.size()); ++line) {
    const auto count = static_cast<int>(grid.lines[static_cast<size_t>(line)].stations.size());
    for (int station = 0; station < count; ++station) {
      if (!std::ranges::binary_search(kept[static_cast<size_t>(line)], station)) {
        dropped.push_back({line, station});
      }
    }
  }
  return dropped;
}

}  // namespace

void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const fs::path& out, bool replace) {
  PartialRoom partial(out, fingerprint_of(room, kept, distance_width), replace);
  const Room part = room.subset(kept);
  Progress progress("thinning", images_of(part), "images");
  for (int i = 0; i < static_cast<int>(kept.size()); ++i) {
    write_line(part, i, room.manifest().distances, distance_width, partial.directory(), &progress);
  }
  write_file_atomically(
      manifest_path(partial.directory()),
      manifest_to_json(manifest_of_volumes(partial.directory(), part.panorama(), part.grid())));
  Room::open(partial.directory());  // checks that the result can be opened
  partial.complete();
}

ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept, const fs::path& out,
                           double tolerance_px) {
  const Room thinned = Room::open(out);
  ThinnedFacts facts{.room = out.string(), .bytes = bytes_in(out)};
  for (size_t line = 0; line < kept.size(); ++line) {
    facts.stations += static_cast<int>(kept[line].size());
    facts.distance_maps += thinned.distances(static_cast<int>(line)).maps();
  }
  const std::vector<HeldOutStation> dropped = dropped_stations(room.grid(), kept);
  const std::vector<int> views = pick_evenly(static_cast<int>(dropped.size()), kMaxViews);
  facts.views = static_cast<int>(views.size());
  facts.psnr_db = facts.worst_psnr_db = kMaxPsnrDb;
  if (views.empty()) return facts;
  facts.psnr_db = 0.0;
  Progress progress("re-creating", std::ssize(views), "stations");
  StationRecreation recreation(room, thinned, tolerance_px);
  for (const int i : views) {
    const double db =
        recreation.score(dropped[static_cast<size_t>(i)], thinned).psnr_with_distances_db;
    facts.psnr_db += db / static_cast<double>(views.size());
    facts.worst_psnr_db = std::min(facts.worst_psnr_db, db);
    progress.advance();
  }
  return facts;
}

}  // namespace raywalk::build_lf
