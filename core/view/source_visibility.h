// Which points of a column a line sees.
//
// A point is hidden from a line if something nearer lies before it on the great circle through the
// acquisition point (visibility.h), or if the distance maps of the stations that are read hold
// something nearer (station_visibility.h). The less the distances can be relied on, the more a line
// is used after all. Rays masked in a station (outside LineVolume::valid_rows) count as not seen by
// it: the point is read from other lines and stations that see it.
//
// Once per column of the distances and source: per row some 30 operations, and as many for each
// distance map where one sees something nearer. With masks, the positions of every output row.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/view/column_distances.h"
#include "core/view/fill_stations.h"
#include "core/view/row_pieces.h"
#include "core/view/station_positions.h"
#include "core/view/station_visibility.h"
#include "core/view/view_inputs.h"
#include "core/view/visibility.h"

namespace raywalk {

// How a source is read where nothing is skipped.
Reading usual_reading(const ViewInputs& view, const RaySource& source);

class SourceVisibility {
 public:
  // For a view with distances. References must outlive the object.
  SourceVisibility(const ViewInputs& view, ColumnDistances& distances, StationPositions& positions,
                   FillStations& fill);

  // How well source `which` of a column sees the rows of the distances, 0 to kSeen. Valid until the
  // next call for the same `which`.
  std::span<const std::uint8_t> usable_rows(const ColumnPoints& points, const RaySource& source,
                                            std::size_t which);

 private:
  static constexpr int kBothStations = -1;

  struct Visible {
    int line = -1;
    bool behind = false;
    int only_station = kBothStations;
    std::vector<std::uint8_t> rows;
  };

  // The station that is read of a source, or kBothStations.
  int only_station(const RaySource& source) const;
  std::span<const std::uint8_t> visible_rows(int depth_theta, const RaySource& source);
  // Sets visible[row] = 0 where a station of the source does not see the point and another one
  // does.
  void remove_hidden_from_stations(int depth_theta, const RaySource& source,
                                   std::vector<std::uint8_t>& visible);
  // Sets usable[row] = 0 where samples of a station are masked or left out.
  void remove_masked(const ColumnPoints& points, int line, int station,
                     std::span<std::uint8_t> usable);

  const ViewInputs& view_;
  ColumnDistances& distances_;
  StationPositions& positions_;
  FillStations& fill_;
  RingVisibility ring_;
  StationVisibility stations_;
  int theta_ = -1;
  std::vector<Visible> visible_;  // in column theta_ of the distances, of the sources used with it
  std::array<std::vector<std::uint8_t>, kMaxSources> usable_;  // of masked lines
  std::vector<std::uint8_t> seen_by_line_;
  PositionArrays samples_;
};

}  // namespace raywalk
