// What is exported of a room, and where to.
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
  std::filesystem::path out{};  // empty: default_export_name
  ExportFormat format = ExportFormat::kColmap;
  bool replace = false;         // an earlier export at `out` is replaced
  int every = 1;                // every n-th station of each line, at least 1
  int face_px = 0;              // side of the flat faces; 0: as fine as the panoramas
  int points = 100'000;         // of a COLMAP model, about
  double voxel_mm = 10.0;       // of a point cloud: one point in each; > 0
  double max_distance_m = 0.0;  // points farther from their station are left out; 0: none are
  bool gains = true;            // pictures and colours with the room's gains
  bool jpeg = false;            // pictures as JPEG instead of PNG
  // Free bytes of the disk that holds a directory, for tests; none: as the system says.
  std::function<std::optional<std::uint64_t>(const std::filesystem::path&)> free_bytes{};
};

// "colmap", "nerfstudio", "frames" or "ply". Throws UsageError naming them for another name.
ExportFormat export_format_from_name(const std::string& name);
std::string name_of(ExportFormat format);

// hall-colmap, in the working directory, for hall.lf; hall.ply of points.
std::filesystem::path default_export_name(const std::filesystem::path& room, ExportFormat format);

}  // namespace raywalk::build_lf
