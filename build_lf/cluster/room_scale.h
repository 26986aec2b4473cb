// How large a room will be, from its frame list: what the work of every step is counted in.
#pragma once

#include <filesystem>
#include <optional>

#include "core/geometry/grid.h"

namespace raywalk::build_lf {

struct RoomScale {
  PanoramaSize panorama{};
  int lines = 0;
  int stations = 0;
  int cells = 0;
  int maps = 0;         // that depth estimates unless told otherwise
  int truth_views = 0;  // rows of a table of true views; 0: none
  int walk_views = 0;   // rows of a table of views to render; 0: none

  double panorama_mpx() const;
  // Of a distance map, whose width is at most 1024 unless depth is told otherwise.
  double map_mpx() const;
};

// The scale of the room that `pack` makes of a frame list. Reads the list and the header of one
// panorama; the others are checked by `pack`. Throws Error as read_frame_list, find_grid and
// panorama_size_of do, and for a table without rows; UsageError if the list is standard input, as
// the machines that do the work read it again.
RoomScale scale_of(const std::filesystem::path& frames, const GridTolerance& tolerance,
                   const std::optional<std::filesystem::path>& truth,
                   const std::optional<std::filesystem::path>& walk);

}  // namespace raywalk::build_lf
