// The table of views that `raywalk-render path` renders.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/connection.h"
#include "render/view/view_frame.h"

namespace raywalk::render {

struct PathView {
  std::string name{};  // of the picture, without extension
  Viewpoint viewpoint{};
  double yaw_deg = 0.0;
  double pitch_deg = 0.0;
  double roll_deg = 0.0;
  double time_s = 0.0;  // as recorded; 0 where the table has no times
  // Where it is in a table that it is not in itself: "between 'a' and 'b'".
  std::string place{};
};

// Columns name,x,z and, where given, y (metres), yaw,pitch,roll (degrees) and time (seconds).
// Throws Error with file and line where a name cannot be a file name or appears twice or there are
// no views, and as CsvTable does.
std::vector<PathView> read_path(const std::filesystem::path& file);

// Throws Error naming file and view if a view cannot be rendered there, for one eye or for two
// `eyes_apart_m`.
void require_inside(const Room& room, const ConnectionRule& rule, const std::filesystem::path& path,
                    std::span<const PathView> views, double eyes_apart_m = 0.0);

// `frame`, turned as the view says.
ViewFrame turned_as(const PathView& view, ViewFrame frame);

}  // namespace raywalk::render
