// The work of `raywalk-render path`: many views, one picture each, or the frames of a video.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/room/room.h"
#include "core/view/view_mode.h"
#include "render/view/path_curve.h"
#include "render/view/path_table.h"
#include "render/view/picture_format.h"
#include "render/view/view_frame.h"

namespace raywalk::render {

// The views of a path.
struct PathRequest {
  std::filesystem::path table{};
  std::optional<SmoothMovement> movement{};  // through the places of the table; none: these alone
};

// Throws Error naming `source` and the view where one cannot be rendered: outside the room, or with
// angles or a height that such views cannot have.
void require_renderable(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                        const std::filesystem::path& source, std::span<const PathView> views);

// Reads the table and checks every view. Throws Error as read_path, frames_of and
// require_renderable do.
std::vector<PathView> views_of(const PathRequest& request, const Room& room, const ViewMode& mode,
                               const ViewFrame& frame);

// Renders every view to `out`/<name>.png, or another format; the directory is created if it is
// missing. `out`/views.json records the settings:
//   {"format_version": 1, "room_sha256", "connection", every parameter by its key, "enlargement",
//    "views": [{"name", "x_m", "z_m"}]}
// with "y_m" of views with a height.
// "enlargement" is enlargement_of().
// Flat pictures add "fov_deg" and "size_px" ("1280x720"), stereo views "stereo" ("ods") and
// "ipd_mm", turned views their angles; "format" is ".png" or another one, "quality" there where it
// was given. `frame` holds the field of view and the size of all views,
// the table their angles. A second run with the same room and settings renders only the missing
// pictures; with others it is refused, so that a directory never holds a mixture. With `replace`,
// views that are there are replaced: the new ones are rendered to `out`.partial, which takes their
// place when it is complete; a directory with anything else in it is refused. Every viewpoint is
// checked before the first is rendered. Returns a one-line summary for the user. Throws Error;
// Interrupted on Ctrl-C, with all finished pictures kept.
std::string write_path(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                       const PathRequest& request, const PictureFormat& format,
                       const std::filesystem::path& out, bool replace = false);

}  // namespace raywalk::render
