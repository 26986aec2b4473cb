// The tolerance with which the lines of a calibrated capture are found.
#pragma once

#include <optional>
#include <vector>

#include "core/files/frame_list.h"
#include "core/geometry/grid.h"

namespace raywalk::calibrate {

// The --line-tolerance-mm with which raywalk-build-lf pack finds these frames on `lines` lines; 0:
// its default is sufficient. nullopt if none is, neither that with which the capture's lines were
// found (`given`) nor one up to half the stations' spacing. Its --same-station-mm is that of
// `given`.
std::optional<double> line_tolerance_needed_mm(const std::vector<ListedFrame>& frames, int lines,
                                               const GridTolerance& given = {});

}  // namespace raywalk::calibrate
