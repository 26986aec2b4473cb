// The work of `raywalk-render path`: many views, one picture each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "render/validation/view_mode.h"
#include "render/view_frame.h"

namespace raywalk::render {

struct PathView {
  std::string name{};  // of the picture, without extension
  PlanPoint viewpoint{};
  double yaw_deg = 0.0;
  double pitch_deg = 0.0;
  double roll_deg = 0.0;
};

// Columns name,x,z (metres) and, where given, yaw,pitch,roll (degrees). Throws Error with file and
// line: a name that cannot be a file's or appears twice, no views at all, and as CsvTable does.
std::vector<PathView> read_path(const std::filesystem::path& file);

// Renders every view to `out`/<name>.png; the directory is made if it is missing. `out`/views.json
// says what they were made with:
//   {"format_version": 1, "room_sha256", "generation", "connection", "k_deg", "layers",
//    "tolerance_px", "overlap_deg", "width_px", "views": [{"name", "x_m", "z_m"}]}
// and, of flat pictures, "fov_deg" and "size_px" ("1280x720"); of a turned view its angles. `frame`
// has the field of view and the size for all views, the table their angles.
// A second run with the same room and settings renders only what is missing; with others it is
// refused, so that a directory never holds a mixture. Every viewpoint is checked before the first
// is rendered. Returns what to tell the user, on one line. Throws Error; Interrupted on Ctrl-C,
// with all finished pictures kept.
std::string write_path(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                       const std::filesystem::path& path, const std::filesystem::path& out);

}  // namespace raywalk::render
