#include "build_lf/export/export_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "build_lf/export/export_colmap.h"
#include "build_lf/export/export_frames.h"
#include "build_lf/export/export_points.h"
#include "build_lf/export/exported_stations.h"
#include "build_lf/pack/free_space.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "core/reconstruction/panorama_faces.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "export.json";
constexpr const char* kSignature = "\"raywalk-export\"";

bool is_part_of_export(const fs::path& relative, bool is_folder) {
  constexpr std::array kExtensions{".png", ".jpg", ".bin", ".txt", ".csv", ".json", ".ply"};
  constexpr std::array kFolders{"images", "masks", "distances", "confidence", "sparse"};
  const bool in_folder = std::ranges::find(kFolders, *relative.begin()) != kFolders.end();
  if (is_folder) return in_folder;
  const bool known = std::ranges::find(kExtensions, relative.extension()) != kExtensions.end();
  return known && (in_folder || !relative.has_parent_path());
}

void require_ranges(const ExportOptions& options) {
  if (options.every < 1) throw UsageError("--every: give 1 or more");
  if (options.points < 0) throw UsageError("--points: give 0 or more");
  if (options.face_px < 0 || options.face_px % 2 != 0) {
    throw UsageError("--face-px: give an even number of pixels, or 0 for that of the panoramas");
  }
  if (!(options.voxel_mm >= 0.01)) throw UsageError("--voxel-mm: give 0.01 or more");
  if (!(options.max_distance_m >= 0.0)) throw UsageError("--max-distance-m: give 0 or more");
}

// Bytes that pictures take at least: photographs are stored in about a third of their pixels' bytes
// as PNG and a thirtieth as JPEG, seldom less.
std::uint64_t least_bytes(const Room& room, std::size_t stations, const ExportOptions& options) {
  const PanoramaSize panorama = room.panorama();
  double pixels = static_cast<double>(panorama.width) * panorama.height;
  if (options.format == ExportFormat::kColmap) {
    const double side = options.face_px > 0 ? options.face_px : native_face_px(panorama.width);
    pixels = static_cast<double>(kCubeFaces.size()) * side * side;
  }
  const double bytes = 3.0 * pixels * static_cast<double>(stations);
  return static_cast<std::uint64_t>(bytes / (options.jpeg ? 30.0 : 3.0));
}

std::string export_folder(const Room& room, const ExportOptions& options, const fs::path& out) {
  OutputFolder folder(out, options.replace,
                      {"an exported room", kMarker, kSignature, is_part_of_export});
  const std::vector<ExportedStation> stations = exported_stations(room, options.every);
  const fs::path& directory = folder.directory();
  require_space(directory, {.needed = least_bytes(room, stations.size(), options)},
                options.free_bytes ? options.free_bytes(directory) : free_bytes(directory),
                "the export");
  const auto write = options.format == ExportFormat::kColmap       ? &write_colmap
                     : options.format == ExportFormat::kNerfstudio ? &write_nerfstudio
                                                                   : &write_frames;
  std::string written = write(room, stations, options, directory);
  write_file_atomically(
      directory / kMarker,
      fmt::format("{{\n  \"format\": {},\n  \"format_version\": 1,\n  \"kind\": \"{}\",\n"
                  "  \"stations\": {}\n}}\n",
                  kSignature, name_of(options.format), stations.size()));
  folder.complete();
  return written;
}

}  // namespace

std::string export_room(const ExportOptions& options) {
  require_ranges(options);
  const fs::path out =
      options.out.empty() ? default_export_name(options.room, options.format) : options.out;
  const Room room = Room::open(options.room);
  if (options.format != ExportFormat::kPly) {
    return fmt::format("{}: {}", out.string(), export_folder(room, options, out));
  }
  if (!options.replace) require_absent(out, "--out");
  require_replaceable_file(out, "an export", kPointsSignature);
  return fmt::format("{}: {} points", out.string(), write_points(room, options, out));
}

}  // namespace raywalk::build_lf
