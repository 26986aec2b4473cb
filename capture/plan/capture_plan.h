// The plan of a capture: every line and station.
//
// World frame of core/geometry/sphere.h: the origin is the middle of the grid at the height of the
// lines. The rail is placed once for each line; its slider then runs along the line in the
// direction of the axis, and station i lies at first_station_mm + i * spacing on the rail. A line
// that is longer than the rail is captured in several placements of the rail, one behind the other:
// the first station of each is at first_station_mm again.
#pragma once

#include <cstddef>
#include <optional>
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
  int placement = 1;  // of the rail on its line, from 1, if this is one of placements_of()
};

// The plan that a plan of some lines is a part of.
struct WholePlan {
  std::vector<std::string> lines{};  // ids of all its lines, in its order
  std::string sha256{};              // whole_plan_of (line_selection.h)
};

struct CapturePlan {
  std::vector<CaptureLine> lines;      // along x in order of z, along z in order of x, validation
  double overhang_m = 0.0;             // planned, whole steps
  std::optional<WholePlan> part_of{};  // none: this is the whole plan
  std::size_t stations() const;        // of all lines, validation included
};

// The parts of a line that are captured in one placement of the rail each: lines of the same id,
// with consecutive stations. A new placement begins where the position on the rail does not
// increase.
std::vector<CaptureLine> placements_of(const CaptureLine& line);
// Of all lines, in the order of the plan.
std::vector<CaptureLine> placements_of(const CapturePlan& plan);

// "x0" for the first placement of a line and for a whole line, "x0-2", "x0-3", ... for further
// ones.
std::string placement_id(const CaptureLine& placement);

// How far views read lines beyond the outer corners of the grid: N / tan(k - blend / 2) for cells
// of side N, in metres, before rounding up to whole steps. Inner corners need no overhang, because
// the line continues along the neighbouring cell.
double overhang_needed_m(const CaptureGrid& grid);

// The largest incidence angle, in degrees, at which views at the worst viewpoint connect with this
// overhang: k if the overhang suffices, 90 without any.
double angle_reached_deg(const CaptureGrid& grid, double overhang_m);

// Throws UsageError naming file, line, key and value for an impossible plan: a spacing of which
// whole steps do not fill the cell's side, a station outside the soft limits, a line that needs
// more placements of the rail than slider.placements_per_line (or several, while it is recorded),
// over 100,000 stations, a validation line that overlaps another line.
CapturePlan plan_capture(const CaptureConfig& config);

// The plan as canonical JSON, lines and stations by their names. A run that resumes a session must
// have the same. It depends only on lines, stations, rail positions, frame kind and bracketing, and
// on the whole plan where this is a part of one. Lengths are rounded to 1 nm, so that rounding
// errors do not change the text.
std::string plan_json(const CapturePlan& plan, const CameraConfig& camera);

}  // namespace raywalk::capture
