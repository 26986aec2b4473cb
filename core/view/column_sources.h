// The lines that a column of a view is read from, how much each counts, and which of its stations
// are mixed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/view/view_options.h"
#include "core/view/view_plan.h"

namespace raywalk {

// Lines that a column is read from: at most two in front and two behind.
inline constexpr std::size_t kMaxSources = 4;

struct ColumnSource {
  RaySource at{};      // the line, and where it is met
  float share = 1.0f;  // among the sources that see a point; of all of them 1 together
  bool behind() const { return at.d_p_m < 0.0; }
};

struct ColumnSources {
  std::size_t count = 0;
  std::array<ColumnSource, kMaxSources> source{};
};

// A line counts by its share in the blend of a connection and by nearness, 1 / |d_p|, so that the
// view is continuous when the eye crosses a line. Where the second side is faded, the share of
// a side goes from 0 to 1 in the middle third; what remains of the other side is a trace, so that
// it is read where only it sees a point.
ColumnSources column_sources(const ColumnPlan& plan, const ViewOptions& options);

// How many stations of a line are mixed, and the part of a spacing over which one fades into the
// next (ViewOptions).
struct StationMix {
  int stations = 1;
  double fade = 0.5;
};
inline StationMix station_mix(const ViewOptions& options) {
  return {options.stations_mixed, options.station_fade};
}

// The share of a station among those of its line that are mixed, which are those nearest in angle
// to the point where the line is met. At either end of these a station fades, so that the view is
// continuous when the eye moves. `from_met`: the station's distance from that point, in spacings.
inline float station_share(double from_met, StationMix mix) {
  const double inside = 0.5 * mix.stations - std::abs(from_met);
  return static_cast<float>(std::clamp(inside / mix.fade + 0.5, 0.0, 1.0));
}

// The stations of a line that have a share.
struct StationWindow {
  int first = 0, last = 0;
};
StationWindow stations_mixed(const RaySource& at, int stations_of_line, StationMix mix);

}  // namespace raywalk
