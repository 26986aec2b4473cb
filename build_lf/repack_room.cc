#include "build_lf/repack_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>

#include "build_lf/distance_sets.h"
#include "build_lf/free_space.h"
#include "build_lf/pack_room.h"
#include "build_lf/partial_room.h"
#include "build_lf/station_data.h"
#include "build_lf/volume_writer.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/folder_size.h"
#include "core/files/output_path.h"
#include "core/files/sha256.h"
#include "core/room/room.h"
#include "core/room/room_fingerprint.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Written anew, of views of the room as it was stored, or what its volumes were packed from: the
// next pack must not take them for volumes of another form.
bool is_left_out(const fs::path& name) {
  constexpr std::array kLeftOut = {"lines",      "distances",     "manifest.json", "lock",
                                   "trade.json", "measured.json", "inputs.json"};
  return name.string().front() == '.' || std::ranges::find(kLeftOut, name) != kLeftOut.end();
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

void repack_line(const Room& room, int index, const RayForm& form, const fs::path& to,
                 Progress* progress) {
  const Line& line = room.grid().lines[static_cast<std::size_t>(index)];
  const LineVolume& volume = room.volume(index);
  write_line_volume(
      to, line,
      {.panorama = room.panorama(),
       .masked = volume.masked(),
       .read = [&](std::size_t i) { return stored_rays(volume, static_cast<int>(i)); },
       .form = form},
      progress);
}

void repack_distances(const DistanceVolume& distances, const Line& line, bool compressed,
                      const fs::path& to, Progress* progress) {
  write_distance_volume(
      to, line,
      {.stations = {distances.stations().begin(), distances.stations().end()},
       .size = distances.size(),
       .origin = distances.origin(),
       .read = [&](std::size_t i) { return stored_distances(distances, static_cast<int>(i)); },
       .compressed = compressed,
       .left_out = distances.left_out().stored_runs(distances.size())},
      progress);
}

// One volume to be written.
struct RepackJob {
  fs::path from;
  fs::path to;
  bool is_copied = false;  // it has the form already
  std::int64_t images = 0;
};

// Does it unless an earlier run has; `convert` writes the volume and advances `progress`.
void run_repack(const RepackJob& job, Progress* progress, const std::function<void()>& convert) {
  throw_if_interrupted();
  const bool done = fs::exists(job.to);
  if (!done && !job.is_copied) {
    convert();
    return;
  }
  if (!done) copy_volume(job.from, job.to);
  for (std::int64_t i = 0; i < job.images; ++i) progress->advance();
}

// The manifest of the room at `out`, whose volumes are complete.
RoomManifest repacked_manifest(const Room& room, const fs::path& out) {
  RoomManifest manifest = room.manifest();
  manifest.rays_sha256.clear();
  for (const Line& line : room.grid().lines) {
    manifest.rays_sha256.push_back(checksum_of_line(line_volume_path(out, line.id)));
  }
  return manifest;
}

// Over everything that determines the result.
std::string fingerprint_of(const Room& room, const RayForm& form) {
  return sha256_hex(fmt::format("repack {}\n{}{}", name_of(form), manifest_to_json(room.manifest()),
                                distances_sha256(room)));
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
  PartialRoom partial(options.out, fingerprint_of(room, options.form), options.replace);
  const fs::path& out = partial.directory();
  require_space_for(room, options, out);
  copy_the_rest(options.room, out);
  const std::vector<Line>& lines = room.grid().lines;
  std::vector<FoundDistances> distances = find_distances(options.room, room.manifest());
  std::erase_if(distances, [](const FoundDistances& found) { return !found.fault.empty(); });
  std::int64_t images = 0;
  for (const Line& line : lines) images += std::ssize(line.stations);
  for (const FoundDistances& found : distances) {
    for (const DistanceVolume& volume : found.volumes) images += volume.maps();
  }
  Progress progress("repacking", images, "images");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int index = static_cast<int>(i);
    const RepackJob rays{line_volume_path(options.room, lines[i].id),
                         line_volume_path(out, lines[i].id),
                         room.volume(index).form() == options.form, std::ssize(lines[i].stations)};
    run_repack(rays, &progress,
               [&] { repack_line(room, index, options.form, rays.to, &progress); });
    for (const FoundDistances& found : distances) {
      const bool compressed = options.form.compressed();
      const DistanceVolume& volume = found.volumes[i];
      const RepackJob maps{distance_volume_path(options.room, lines[i].id, found.kind),
                           distance_volume_path(out, lines[i].id, found.kind),
                           volume.compressed() == compressed || volume.maps() == 0, volume.maps()};
      run_repack(maps, &progress,
                 [&] { repack_distances(volume, lines[i], compressed, maps.to, &progress); });
    }
  }
  write_file_atomically(manifest_path(out), manifest_to_json(repacked_manifest(room, out)));
  Room::open(out);  // checks that the result can be opened
  partial.complete();
}

}  // namespace raywalk::build_lf
