// The work of `raywalk-render view`: one rendered view as a picture file.
#pragma once

#include <filesystem>
#include <string>

#include "core/room/room.h"
#include "core/view/view_mode.h"
#include "render/view/picture_format.h"
#include "render/view/view_frame.h"
#include "render/view/view_metadata.h"

namespace raywalk::render {

// The viewpoint of --at: "X,Z" or "X,Y,Z" in metres, with a comma, spaces or both between. Throws
// UsageError for anything else.
Viewpoint viewpoint_from_text(const std::string& text);

// Throws Error unless the file can be created. Call before rendering, so that an unusable path
// fails early.
void require_writable_picture(const std::filesystem::path& file);
// The same of a view, which replaces nothing but pictures whose metadata name Raywalk.
void require_writable_view(const std::filesystem::path& file);

// The distances that views of this mode are corrected by: Room::distances_origin(), or "none".
std::string distances_used(const Room& room, const ViewMode& mode);

// Where the lines of a cell are connected in views of this mode.
ConnectionRule connection_rule(const ViewMode& mode);

// What the picture of a view tells other programs. Throws Error where the room cannot be rendered.
ViewDescription describe_view(const Room& room, const ViewMode& mode, const Viewpoint& viewpoint,
                              const ViewFrame& frame);

// How a view was rendered, on one line: "hlf-vd, hybrid at k = 80 degrees (...), ...".
std::string view_summary(const ViewMode& mode, const ViewReport& report);

// Renders the view at `viewpoint`, one or two panoramas turned as the frame says or a flat picture,
// and writes it; returns a one-line summary for the user. Throws Error where the room cannot be
// rendered or the picture not written; no file is left behind then.
std::string write_view(const Room& room, const ViewMode& mode, const Viewpoint& viewpoint,
                       const ViewFrame& frame, const std::filesystem::path& file,
                       const PictureFormat& format = {});

}  // namespace raywalk::render
