// The points of a room's distances, coloured, for measuring tools.
#pragma once

#include <cstdint>
#include <filesystem>

#include "build_lf/export/export_options.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Writes a PLY (binary, little-endian) of one point in each cube of options.voxel_mm: float x, y, z
// in metres (x right, y forward, z up: right-handed), uchar red, green, blue, confidence (64 to
// 255). Returns the number of points. Memory is bounded: where all cubes would not fit, the maps
// are read several times. Throws Error if the room has no distances, none of them counts, or the
// file cannot be written; then there is none.
std::int64_t write_points(const Room& room, const ExportOptions& options,
                          const std::filesystem::path& file);

// The text by which such a file is known.
inline constexpr const char* kPointsSignature = "comment Raywalk";

}  // namespace raywalk::build_lf
