// Exports a room for other reconstruction and measuring programs (docs/other-reconstructions.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace raywalk::build_lf {

enum class ExportFormat { kColmap, kNerfstudio, kFrames, kPly };

struct ExportOptions {
  std::filesystem::path room{};
  std::filesystem::path out{};  // empty: named after the room, hall-colmap or hall.ply
  ExportFormat format = ExportFormat::kColmap;
  bool replace = false;         // an earlier export at `out` is replaced
  int every = 1;                // every n-th station of each line, at least 1
  int face_px = 0;              // side of the flat faces, even; 0: as fine as the panoramas
  int points = 100'000;         // of a COLMAP model, at most; at least 0
  double voxel_mm = 10.0;       // of a point cloud: one point in each; > 0
  double max_distance_m = 0.0;  // points farther from their station are left out; 0: none are
  bool gains = true;            // pictures and colours with the room's gains
  bool jpeg = false;            // pictures as JPEG instead of PNG
  // Free bytes of the disk that holds a directory, for tests; none: as the system says.
  std::function<std::optional<std::uint64_t>(const std::filesystem::path&)> free_bytes{};
};

// "colmap", "nerfstudio", "frames" or "ply". Throws UsageError naming them for another name.
ExportFormat export_format_from_name(const std::string& name);

// Returns what was written, a line for the user. Throws UsageError for an odd side of faces, Error
// as Room::open does, if `out` is in the way, the disk is too small or cannot be written;
// Interrupted. Then nothing is left.
std::string export_room(const ExportOptions& options);

}  // namespace raywalk::build_lf
