// The plan of a pack run. Making it checks all input before any work starts: every frame and
// distance map exists with the right size, and every station belongs to a line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"
#include "core/room/ray_form.h"

namespace raywalk::build_lf {

struct PackOptions {
  std::filesystem::path frames;  // the frame list, poses.csv; "-": standard input
  std::filesystem::path out;     // the room directory to create
  std::optional<std::filesystem::path> distances{};  // directory of distance maps
  GridTolerance tolerance{};                         // how lines are found
  RayForm form{};                                    // how rays are stored
  // Free bytes of the disk that holds a directory, for tests; none: as the system says.
  std::function<std::optional<std::uint64_t>(const std::filesystem::path&)> free_bytes{};
  bool replace = false;  // a room at `out` is replaced
};

// The input files of a station.
struct StationSource {
  std::filesystem::path panorama;
  std::optional<Attitude> attitude;                   // none: already in world axes
  std::optional<std::filesystem::path> distance_map;  // <stem of the frame>.png
  std::optional<std::filesystem::path> mask{};        // in the frame's own axes, 0 = invalid
  std::string where{};                                // "poses.csv:12", for errors
};

// What the volumes of a line are made from, as SHA-256 over everything that determines their bytes:
// format, form of the rays, id and positions of the line, panorama size, attitudes, and name, size
// and modification time of every file.
struct LineInputs {
  std::string rays{};
  std::string distances{};  // empty: the line has no maps
  friend bool operator==(const LineInputs&, const LineInputs&) = default;
};

struct PackPlan {
  PanoramaSize panorama;
  PanoramaSize distance_map;  // 0 x 0 if there are no maps
  Grid grid;
  RayForm form{};
  std::vector<std::vector<StationSource>> sources;  // [line][station]
  std::vector<LineInputs> inputs{};                 // [line]

  // Whether any station has a distance map; then every line gets a volume of them.
  bool has_maps() const { return distance_map.width > 0; }
  // Bytes of a line's volumes, without headers. Of compressed rays an estimate: few scenes take
  // more.
  std::uint64_t bytes_of_rays(std::size_t line) const;
  std::uint64_t bytes_of_maps(std::size_t line) const;
};

// The room that `pack` makes of a frame list unless told otherwise: hall.lf, in the working
// directory, for hall/poses.csv and for hall/calibration/poses.csv.
std::filesystem::path default_room_name(const std::filesystem::path& frames);

// Warns of positions that look like millimetres and of EXIF orientations. Throws Error as
// read_frame_list and find_grid do, and for: a frame that is missing or not an
// image, frames of different sizes, a mask that is missing, of another size or not grey, a distance
// directory without a map of any frame, a map whose size differs from the others' or exceeds the
// panorama's.
PackPlan plan_pack(const PackOptions& options);

}  // namespace raywalk::build_lf
