// The crossings before and after, as an HTML table.
#pragma once

#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/grid/grid_result.h"
#include "core/report/html_page.h"

namespace raywalk::calibrate {

// "x0 / z1".
std::string crossing_name(const CaptureSet& set, int along_x, int along_z);

// The disagreement of the two lines at every crossing, before and after.
HtmlTable crossing_table(const CaptureSet& set, const std::vector<CrossingFigures>& crossings);

}  // namespace raywalk::calibrate
