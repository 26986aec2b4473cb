#include "build_lf/pack/repack_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "build_lf/pack/derived_volumes.h"
#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/free_space.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/partial_room.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Written anew, of views of the room as it was stored, or what its volumes were packed from: the
// next pack must not take them for volumes of another form.
bool is_left_out(const fs::path& name) {
  constexpr std::array kLeftOut = {"lines",      "distances",     "manifest.json", "lock",
                                   "trade.json", "measured.json", "inputs.json"};
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
  std::vector<FoundDistances> distances = find_distances(options.room, room.manifest());
  std::erase_if(distances, [](const FoundDistances& found) { return !found.fault.empty(); });
  const std::vector<Line>& lines = room.grid().lines;
  std::int64_t images = 0;
  for (const Line& line : lines) images += std::ssize(line.stations);
  for (const FoundDistances& found : distances) {
    for (const DistanceVolume& volume : found.volumes) images += volume.maps();
  }
  Progress progress("repacking", images, "images");
  constexpr int kAnyWidth = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    write_derived_rays(room, room, static_cast<int>(i), options.form, out, &progress);
    for (const FoundDistances& found : distances) {
      write_derived_maps(found.volumes[i], lines[i], found.kind, kAnyWidth,
                         options.form.compressed(), out, &progress);
    }
  }
  write_file_atomically(manifest_path(out), manifest_to_json(repacked_manifest(room, out)));
  Room::open(out);  // checks that the result can be opened
  partial.complete();
}

}  // namespace raywalk::build_lf
