#include "build_lf/export/export_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "build_lf/export/export_colmap.h"
#include "build_lf/export/export_frames.h"
#include "build_lf/export/exported_stations.h"
#include "build_lf/export/point_cloud.h"
#include "build_lf/pack/free_space.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "core/reconstruction/panorama_faces.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// In the order of ExportFormat.
constexpr std::array kFormatNames{"colmap", "nerfstudio", "frames", "ply"};
constexpr std::array kWriters{&write_colmap, &write_nerfstudio, &write_frames};

std::string name_of(ExportFormat format) { return kFormatNames[static_cast<std::size_t>(format)]; }

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
  const auto write = kWriters[static_cast<std::size_t>(options.format)];
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

ExportFormat export_format_from_name(const std::string& name) {
  const auto known = std::ranges::find(kFormatNames, name);
  if (known != kFormatNames.end()) {
    return static_cast<ExportFormat>(known - kFormatNames.begin());
  }
  throw UsageError(
      fmt::format("--format {}: unknown; give colmap, nerfstudio, frames or ply", excerpt(name)));
}

std::string export_room(const ExportOptions& options) {
  if (options.face_px % 2 != 0) {
    throw UsageError("--face-px: give an even number of pixels, or 0 for that of the panoramas");
  }
  const bool is_file = options.format == ExportFormat::kPly;
  fs::path out = options.out;
  if (out.empty()) {
    const fs::path room = fs::absolute(without_trailing_slash(options.room)).lexically_normal();
    out = room.stem().string() + (is_file ? "." : "-") + name_of(options.format);
  }
  const Room room = Room::open(options.room);
  if (!is_file) return fmt::format("{}: {}", out.string(), export_folder(room, options, out));
  if (!options.replace) require_absent(out, "--out");
  require_replaceable_file(out, "an export", kPointsSignature);
  return fmt::format("{}: {} points", out.string(), write_points(room, options, out));
}

}  // namespace raywalk::build_lf
