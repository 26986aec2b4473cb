// Writes the files of an export's stations.
#pragma once

#include <filesystem>

#include "core/room/room.h"
#include "core/view/view_options.h"

namespace raywalk::render {

// Writes NAME.jpg, NAME-coarse.jpg and NAME.inverse of all stations of `room` to `folder`;
// `options` are those of views, as wide as the panoramas. Returns the step of the distances'
// values, 1/m: the largest inverse distance of all stations is 65535 of them. Memory does not grow
// with the number of stations. Throws Error, and Interrupted, saying how far it got.
double write_stations(const Room& room, const ViewOptions& options, int distance_width,
                      const std::filesystem::path& folder);

}  // namespace raywalk::render
