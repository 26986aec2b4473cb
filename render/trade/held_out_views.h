// Ground truth without captured views between the lines: stations of the room itself, left out and
// rendered again from the others (rephotography).
//
// Such a view lies on a line, so that its outer half is read from the neighbours on that line, and
// only the inner half from across the cell; settings rank there as they do between the lines.
// Leaving out the neighbours too, so that all is read from farther off, ranks worse: what is seen
// from beside the line is hidden otherwise than what is seen from in front of it.
//
// Distances that were estimated from the frames are estimated again without those left out;
// distances that were given lose these stations' maps.
#pragma once

#include <memory>
#include <vector>

#include "core/room/room.h"
#include "render/trade/trade_view.h"

namespace raywalk::render {

struct HeldOutViews {
  std::unique_ptr<Room> room{};    // that the views are rendered from
  std::vector<TradeView> views{};  // truths are the frames as they were packed
};

// The room without one of `every` stations (held_out_stations()). Where its distances were
// estimated, those of ROOM/held-out take their place; they are estimated first, by
// raywalk-build-lf depth of this program's directory with the settings that ROOM/depth.json tells,
// unless that was done already. Throws UsageError for an `every` below 2; Error where the distances
// cannot be estimated; Interrupted.
Room room_without_held_out(const Room& room, int every);

// At most `most` of the held-out stations that a view can be rendered at, spread over the lines.
// Throws as room_without_held_out(); Error where there is none.
HeldOutViews held_out_views(const Room& room, int every, std::size_t most);

}  // namespace raywalk::render
