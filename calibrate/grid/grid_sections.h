// What the pages of a grid and of a whole calibration both show.
#pragma once

#include "core/report/json_page.h"

namespace raywalk::calibrate {

// All take a page of grid.json or calibration.json.

// Whether the result is trustworthy, by how much lines disagree at most, warnings and notes.
void add_verdict(JsonPage page);

// The disagreement of the lines at each crossing of a list; nothing if it has none.
void add_crossings(std::string_view list, const JsonPage& page);

// Every line against the plan, with the models of its rail.
void add_lines(JsonPage page);

}  // namespace raywalk::calibrate
