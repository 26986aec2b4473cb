// The lines that a column of a view is read from, how much each counts, and which of its stations
// are mixed.
#pragma once

#include <array>
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

// The share of a station among those of its line that are mixed: the `mixed` stations around the
// point where the line is met are those nearest in angle. Over the sixth of a spacing at either end
// a station fades, so that the view is continuous when the eye moves. `from_met`: the station's
// distance from that point, in spacings.
inline float station_share(float from_met, int mixed) {
  const float inside = 0.5f * static_cast<float>(mixed) - (from_met < 0.0f ? -from_met : from_met);
  const float share = 6.0f * inside + 0.5f;
  return share < 0.0f ? 0.0f : (share > 1.0f ? 1.0f : share);
}

// The stations of a line that have a share.
struct StationWindow {
  int first = 0, last = 0;
};
StationWindow stations_mixed(const RaySource& at, int stations_of_line, int mixed);

}  // namespace raywalk
