// Every line and station of a capture, before anything moves.
//
// World frame of core/geometry/sphere.h: the origin is the middle of the grid at the height of the
// lines. The rail is placed anew for each line; its slider then runs along the line in the
// direction of the axis, and station i lies at first_station_mm + i * spacing on the rail.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "capture/config/capture_config.h"
#include "core/geometry/grid.h"

namespace raywalk::capture {

struct CaptureStation {
  std::string name;      // "<line>_<number>", for example x0_007
  PlanPoint position_m;  // world frame; y = 0
  double rail_mm = 0.0;  // planned position on the rail
};

struct CaptureLine {
  std::string id;  // as Line::id of core/geometry/grid.h; "v0", "v1", ... for validation
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;  // z of a line along x, x of a line along z
  bool validation = false;
  std::vector<CaptureStation> stations;  // in order along the axis
};

struct CapturePlan {
  std::vector<CaptureLine> lines;  // along x in order of z, along z in order of x, validation
  double overhang_m = 0.0;         // planned, whole steps
  std::size_t stations() const;    // of all lines, validation included
};

// How far beyond the outer corners of a cell views read its lines: N / tan(k - blend / 2) for cells
// of side N, in metres, before rounding up to whole steps. Corners
// inside of the grid need none: the neighbouring cell's line goes on there.
double overhang_needed_m(const CaptureGrid& grid);

// The largest incidence angle, in degrees, that views reach at the worst viewpoint with so much
// overhang captured: k where it suffices, 90 without any.
double angle_reached_deg(const CaptureGrid& grid, double overhang_m);

// Throws UsageError naming file, line, key and value where a plan cannot be: a spacing that does
// not fill the cell's side in whole steps, a station outside of the soft limits, over 100,000
// stations, a validation line that shares a stretch with another line.
CapturePlan plan_capture(const CaptureConfig& config);

// The plan as canonical JSON: what a session remembers and a later run is held to. It depends on
// lines, stations, rail positions, frame kind and bracketing alone. Lengths are rounded to 1 nm, so
// that the same plan gives the same text whatever the last bit of a sum is.
std::string plan_json(const CapturePlan& plan, const CameraConfig& camera);

}  // namespace raywalk::capture
