// Truths that were captured between the lines, as `validate` reads them, and the rooms to render
// them from.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/judge/trade/trade_view.h"
#include "core/judge/validation/truth_views.h"

namespace raywalk {

// depth_name() of a room without distances.
inline constexpr const char* kNoDepth = "none";

// The source of a room's distances and the width of its maps: "given, 512 px",
// "estimated by sweep, 1024 px", kNoDepth.
std::string depth_name(const Room& room);

// The views of at most `most` truths, spread evenly over the distance from the line, to be rendered
// from `room`. Throws Error where a picture cannot be read, or two differ in width.
std::vector<TradeView> captured_views(const Room& room, const std::vector<TruthView>& truths,
                                      std::size_t most);

// The same views, to be rendered from another room of the same place.
TradeRoom trade_room(const Room& room, std::span<const TradeView> views);

// Throws Error unless the lines of both rooms begin and end at the same positions within a
// millimetre.
void require_same_lines(const Room& room, const Room& other);

}  // namespace raywalk
