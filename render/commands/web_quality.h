// What an export loses by leaving stations out.
#pragma once

#include <optional>

#include "render/web/export_web.h"

namespace raywalk::render {

// Renders the views at stations that `kept` leaves out, at most 24 spread over the room, from the
// stations kept, and compares them at the width of the views with what was captured there, gains
// applied in both. Pixels that views do not show (masks, left out) are not compared, nor stations
// beyond the cells, where nothing is rendered. None where no station can be compared. Throws
// Interrupted.
std::optional<WebQuality> measure_web_quality(const Room& room, const KeptStations& kept,
                                              const ViewOptions& options);

}  // namespace raywalk::render
