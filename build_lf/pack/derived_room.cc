#include "build_lf/pack/derived_room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/free_space.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/room_folder.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/distance_maps.h"
#include "core/room/gain_fields.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// A map at another width: inverse distances interpolated as in InverseMap, confidence of the
// nearest pixel.
StationDistances reduced_distances(const DistanceVolume& volume, int map, int width) {
  const InverseMap inverse = resized(inverse_map_of(volume, map), width);
  const double scale = static_cast<double>(volume.size().width) / width;
  StationDistances distances;
  for (int theta = 0; theta < width; ++theta) {
    const auto confidence = volume.confidence_column(map, static_cast<int>((theta + 0.5) * scale));
    for (int row = 0; row < width / 2; ++row) {
      const float known = inverse.at(theta, row);
      const auto from = static_cast<size_t>((row + 0.5) * scale);
      distances.distance_m.push_back(known < 0.0f ? 0.0f : 1.0f / known);
      distances.confidence.push_back(known < 0.0f ? std::uint8_t{0} : confidence[from]);
    }
  }
  distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
  return distances;
}

// How the volumes of a room are made of those of another one.
struct Derivation {
  const Room& room;
  const Room& part;                                  // `room` itself or some of its stations
  std::vector<FoundDistances> distances{};           // of `part`
  std::optional<RayForm> form{};                     // none: that which each line has
  int most_width = std::numeric_limits<int>::max();  // of maps; wider ones are reduced
  std::string inputs{};                              // of what is not copied

  RayForm form_of(int line) const { return form.value_or(part.volume(line).form()); }
  // What is stored as JPEG would lose once more. Volumes of other programs may lack checksums: to
  // write other forms again gives them some.
  bool is_copied(int line) const {
    return form_of(line).kind == RayForm::Kind::kJpeg &&
           part.volume(line).form() == form_of(line) &&
           part.volume(line).stations() == room.volume(line).stations();
  }
};

void derive_rays(const Derivation& of, int index, const RoomFolder& folder, Progress* progress) {
  throw_if_interrupted();
  const Line& line = of.part.grid().lines[static_cast<std::size_t>(index)];
  const LineVolume& rays = of.part.volume(index);
  const fs::path file = line_volume_path(folder.directory(), line.id);
  if (fs::exists(file)) return progress->advance(rays.stations());
  if (of.is_copied(index)) {
    copy_volume(line_volume_path(of.room.directory(), line.id), file);
    return progress->advance(rays.stations());
  }
  write_line_volume(file, line,
                    {.panorama = of.part.panorama(),
                     .masked = rays.masked(),
                     .read = [&](size_t i) { return stored_rays(rays, static_cast<int>(i)); },
                     .form = of.form_of(index),
                     .inputs = of.inputs},
                    progress);
}

void derive_maps(const Derivation& of, const FoundDistances& found, int index,
                 const RoomFolder& folder, Progress* progress) {
  throw_if_interrupted();
  const Line& line = of.part.grid().lines[static_cast<std::size_t>(index)];
  const DistanceVolume& maps = found.volumes[static_cast<std::size_t>(index)];
  const fs::path file = distance_volume_path(folder.directory(), line.id, found.kind);
  if (fs::exists(file)) return progress->advance(maps.maps());
  const int width = std::min(of.most_width, maps.size().width);
  const auto read = [&](size_t i) {
    return width < maps.size().width ? reduced_distances(maps, static_cast<int>(i), width)
                                     : stored_distances(maps, static_cast<int>(i));
  };
  write_distance_volume(file, line,
                        {.stations = {maps.stations().begin(), maps.stations().end()},
                         .size = {width, width / 2},
                         .origin = maps.origin(),
                         .read = read,
                         .compressed = of.form_of(index).compressed(),
                         .left_out = maps.left_out().stored_runs({width, width / 2}),
                         .inputs = of.inputs},
                        progress);
}

std::vector<PlannedVolume> volumes_of(const Derivation& of) {
  std::vector<PlannedVolume> volumes;
  const std::vector<Line>& lines = of.part.grid().lines;
  for (int i = 0; i < static_cast<int>(lines.size()); ++i) {
    const std::string& id = lines[static_cast<std::size_t>(i)].id;
    volumes.push_back(
        {line_volume_path("", id),
         of.is_copied(i) ? inputs_of(line_volume_path(of.room.directory(), id)) : of.inputs});
    for (const FoundDistances& found : of.distances) {
      volumes.push_back({distance_volume_path("", id, found.kind), of.inputs});
    }
  }
  return volumes;
}

void derive_volumes(const Derivation& of, const char* doing, const RoomFolder& folder) {
  const int lines = static_cast<int>(of.part.grid().lines.size());
  std::int64_t images = 0;
  for (int i = 0; i < lines; ++i) {
    images += of.part.volume(i).stations();
    for (const FoundDistances& found : of.distances) {
      images += found.volumes[static_cast<std::size_t>(i)].maps();
    }
  }
  Progress progress(doing, images, "images");
  for (int i = 0; i < lines; ++i) {
    derive_rays(of, i, folder, &progress);
    for (const FoundDistances& found : of.distances) derive_maps(of, found, i, folder, &progress);
  }
}

// Written anew, or of views of the room as it was stored.
bool is_left_out(const fs::path& name) {
  constexpr std::array kLeftOut = {"lines", "distances",  "manifest.json",
                                   "lock",  "trade.json", "measured.json"};
  return name.string().front() == '.' || name.extension() == ".partial" ||
         std::ranges::find(kLeftOut, name) != kLeftOut.end();
}

void copy_the_rest(const fs::path& from, const fs::path& to) {
  constexpr auto kHow = fs::copy_options::recursive | fs::copy_options::overwrite_existing;
  for (const fs::directory_entry& entry : fs::directory_iterator(from)) {
    throw_if_interrupted();
    const fs::path name = entry.path().filename();
    if (is_left_out(name)) continue;
    std::error_code error;
    fs::copy(entry.path(), to / name, kHow, error);
    if (error) {
      throw Error(fmt::format("{}: cannot be copied to {}: {}", entry.path().string(), to.string(),
                              error.message()));
    }
  }
}

void require_space_for(const Room& room, const RepackOptions& options, const fs::path& partial) {
  const std::uint64_t rays = bytes_in(options.room / "lines");
  std::uint64_t raw = 0;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    raw += static_cast<std::uint64_t>(room.volume(line).stations()) *
           room.volume(line).station_bytes();
  }
  const std::uint64_t needed = bytes_in(options.room) - rays + estimated_bytes(options.form, raw);
  const std::uint64_t there = std::min<std::uint64_t>(bytes_in(partial), needed);
  require_space(partial, {.needed = needed - there, .there = there}, free_bytes(partial));
}

}  // namespace

fs::path default_repacked_name(const fs::path& room, const RayForm& form) {
  const fs::path plain = without_trailing_slash(room);
  const std::string how = form.kind == RayForm::Kind::kJpeg
                              ? fmt::format("jpeg{}", form.jpeg_quality)
                          : form.compressed() ? "lossless"
                                              : "raw";
  return plain.parent_path() / (plain.stem().string() + "-" + how + plain.extension().string());
}

void repack_room(const RepackOptions& options) {
  require_free(without_trailing_slash(options.out), options.replace);
  const Room room = Room::open(options.room);
  Derivation derivation{
      .room = room,
      .part = room,
      .distances = find_distances(options.room, room.manifest()),
      .form = options.form,
      .inputs = sha256_hex(fmt::format("repack {}\n{}{}", name_of(options.form),
                                       manifest_to_json(room.manifest()), distances_sha256(room)))};
  std::erase_if(derivation.distances,
                [](const FoundDistances& found) { return !found.fault.empty(); });
  RoomFolder folder(options.out, volumes_of(derivation), options.replace);
  require_space_for(room, options, folder.directory());
  derive_volumes(derivation, "repacking", folder);
  copy_the_rest(options.room, folder.directory());
  RoomManifest manifest = room.manifest();
  manifest.rays_sha256 =
      manifest_of_volumes(folder.directory(), room.panorama(), room.grid()).rays_sha256;
  folder.complete(manifest);
}

void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const fs::path& out, bool replace) {
  const Room part = room.subset(kept);
  Derivation derivation{.room = room,
                        .part = part,
                        .most_width = distance_width,
                        .inputs = sha256_hex(fmt::format("thin {}{} {}", room_fingerprint(room),
                                                         kept, distance_width))};
  if (const DistanceKind in_use = room.manifest().distances; in_use != DistanceKind::kNone) {
    FoundDistances& found = derivation.distances.emplace_back();
    found.kind = in_use;
    for (int i = 0; i < static_cast<int>(kept.size()); ++i) {
      found.volumes.push_back(part.distances(i));
    }
  }
  RoomFolder folder(out, volumes_of(derivation), replace);
  derive_volumes(derivation, "thinning", folder);
  RoomManifest manifest = manifest_of_volumes(folder.directory(), part.panorama(), part.grid());
  if (!part.gains().empty()) {
    write_gain_fields(gains_path(folder.directory()), part.grid(), part.gains());
    manifest.gains = true;
  }
  folder.complete(manifest);
}

}  // namespace raywalk::build_lf
