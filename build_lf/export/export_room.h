// Exports a room for other reconstruction and measuring programs (docs/other-reconstructions.md).
#pragma once

#include <string>

#include "build_lf/export/export_options.h"

namespace raywalk::build_lf {

// Returns what was written, a line for the user. Throws UsageError for options out of range, Error
// as Room::open does, if `out` is in the way, the disk is too small or cannot be written;
// Interrupted. Then nothing is left.
std::string export_room(const ExportOptions& options);

}  // namespace raywalk::build_lf
