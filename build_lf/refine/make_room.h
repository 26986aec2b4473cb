// From photographs to a room for views in one command: `raywalk-build-lf all`.
#pragma once

#include <string>

#include "build_lf/pack/pack_plan.h"

namespace raywalk::build_lf {

// Packs the frames, estimates distances and refines. What earlier runs finished of the same frames
// is kept, so that the same command resumes a stopped run; with `replace` a room of other frames is
// replaced, and the refined one with it. Returns a summary that ends with the command of a view.
// Throws as pack_room, estimate_depth and refine_room do.
std::string make_room(const PackOptions& options);

}  // namespace raywalk::build_lf
