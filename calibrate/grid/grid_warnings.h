// Warnings and notes about an estimate.
#pragma once

#include "calibrate/grid/grid_result.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// Fills in warnings, notes and trustworthy from the lines and crossings of the result. It is
// trustworthy if there are no warnings, of crossings or of lines.
void add_warnings(const CaptureSet& set, const GridScale& scale, GridResult* result);

}  // namespace raywalk::calibrate
