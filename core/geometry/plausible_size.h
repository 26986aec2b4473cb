// Whether a grid has a size that rooms have.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/grid.h"

namespace raywalk {

// Why the positions look like millimetres or centimetres, and what to do; none if they do not.
// Stations of rooms are millimetres to decimetres apart and cells a few metres wide. Doubtful: more
// than 2 m between neighbours of the most widely spaced line, or a cell wider than 50 m.
std::optional<std::string> doubt_of_unit(const Grid& grid);

}  // namespace raywalk
