// The figures of the report of `raywalk-build-lf require` that are not plots of its JSON's lists.
#pragma once

#include <vector>

#include "build_lf/require/thin_room.h"
#include "core/report/html_page.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

struct RequirementFigures {
  HtmlFigure directions{};
  std::vector<HtmlFigure> around{};  // the room and its distances seen from above
  HtmlFigure layers{};
  HtmlFigure ghosts{};
  std::vector<HtmlFigure> connection{};  // none where the room has no cell
};

// `needed` are the stations needed with distances.
RequirementFigures requirement_figures(const Room& room, const RoomRequirements& requirements,
                                       const KeptStations& needed);

}  // namespace raywalk::build_lf
