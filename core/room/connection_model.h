// The modelled connection error E_t (6) of a room: core/geometry/error_model.h over the room's
// own cells, spacing and distances.
#pragma once

#include "core/geometry/error_model.h"
#include "core/room/room.h"

namespace raywalk {

// N is the mean side of the cells (at least one), the step of (3) the median over the lines of
// their median spacing.
CellSampling cell_sampling(const Grid& grid);

struct ConnectionModel {
  ConnectionErrorCurve curve{};
  bool from_distances = false;  // else from the paper's d_src = 1.5 N
};

// E_t summed over quantiles of the room's distances, each representing an equal share of the pixels
// by solid angle and confidence. The room must have a cell.
ConnectionModel connection_model(const Room& room);

}  // namespace raywalk
