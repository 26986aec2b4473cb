// Stations of a room as ground truth without captured views between the lines: they are left out
// and rendered again from the others (rephotography). Such a view lies on a line: its outer half is
// read from the neighbours on that line, only the inner half from across the cell. Settings rank
// there as they do between the lines. Leaving out the neighbours too, so that everything is read
// from farther away, ranks worse, because occlusions beside a line differ from those in front of
// it.
//
// Distances that were estimated from the frames are estimated again without those left out;
// given distances lose the maps of these stations.
#pragma once

#include <cstddef>
#include <vector>

#include "core/evaluate/truth_views.h"
#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk {

// The stations left out ([line], increasing indices) where views can be rendered: not those on an
// overhang beyond the cells.
std::vector<StationIndex> stations_with_views(const Grid& grid, const KeptStations& left_out);

// What a station captured, without gains, and where.
TrueView true_view_of(const Room& room, StationIndex station);

struct HeldOutViews {
  Room room{};                    // the views are rendered from it
  std::vector<TrueView> views{};  // images are the packed frames
};

// The room without one of `every` stations (held_out_stations()). Estimated distances are replaced
// by those of ROOM/held-out; where these do not exist yet, raywalk-build-lf depth (from this
// program's directory) estimates them with the settings recorded in ROOM/depth.json. Throws
// UsageError for an `every` below 2; Error where the distances cannot be estimated; Interrupted.
Room room_without_held_out(const Room& room, int every);

// At most `most` of the held-out stations where a view can be rendered, spread over the lines.
// Throws as room_without_held_out(); Error where there is none.
HeldOutViews held_out_views(const Room& room, int every, std::size_t most);

}  // namespace raywalk
