// The work of `raywalk-render path --video`: the views of a path as a video.
#pragma once

#include <filesystem>
#include <string>

#include "render/video/video_codec.h"
#include "render/view/view_path.h"

namespace raywalk::render {

// Renders the views of a path and encodes them to `file`: a panorama video with spherical metadata,
// or a flat one where `frame` has a field of view. The file appears when it is complete; one that
// is there already is replaced only with `replace`, and only if it is a video of Raywalk's.
// Everything is checked before the first view is rendered. Returns a one-line summary for the user.
// Throws UsageError, Error; Interrupted on Ctrl-C: a video that was stopped leaves nothing and
// starts again.
std::string write_video(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                        const PathRequest& request, const VideoSettings& settings,
                        const std::filesystem::path& file, bool replace = false);

}  // namespace raywalk::render
