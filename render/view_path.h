// The work of `raywalk-render path`: many views, one picture each.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/connection.h"
#include "core/view/view_mode.h"
#include "render/view_frame.h"

namespace raywalk::render {

struct PathView {
  std::string name{};  // of the picture, without extension
  PlanPoint viewpoint{};
  double yaw_deg = 0.0;
  double pitch_deg = 0.0;
  double roll_deg = 0.0;
};

// The frame turned as the view says.
ViewFrame turned_as(const PathView& view, ViewFrame frame);

// Columns name,x,z (metres) and, where given, yaw,pitch,roll (degrees). Throws Error with file and
// line where a name cannot be a file name or appears twice or there are no views, and as CsvTable
// does.
std::vector<PathView> read_path(const std::filesystem::path& file);

// Throws Error naming file and view if a view cannot be rendered there.
void require_inside(const Room& room, const ConnectionRule& rule, const std::filesystem::path& path,
                    std::span<const PathView> views);

// Renders every view to `out`/<name>.png; the directory is created if it is missing.
// `out`/views.json records the settings:
//   {"format_version": 1, "room_sha256", "connection", every dial by its key, "enlargement",
//    "views": [{"name", "x_m", "z_m"}]}
// "enlargement" is enlargement_of().
// Flat pictures add "fov_deg" and "size_px" ("1280x720"), turned views their angles. `frame` holds
// the field of view and the size of all views, the table their angles. A second run with the same
// room and settings renders only the missing pictures; with others it is refused, so that a
// directory never holds a mixture. With `replace`, views that are there are replaced: the new ones
// are rendered to `out`.partial, which takes their place when it is complete; a directory with
// anything else in it is refused. Every viewpoint is checked before the first is rendered. Returns
// a one-line summary for the user. Throws Error; Interrupted on Ctrl-C, with all finished pictures
// kept.
std::string write_path(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                       const std::filesystem::path& path, const std::filesystem::path& out,
                       bool replace = false);

}  // namespace raywalk::render
