// Reading ahead from the disk. A view needs a few bytes in each of some 200,000 pages of the
// volumes, most of them around the poles, where neighbouring rows lie in far-off columns. Where
// they are not in memory yet, as after opening a room, each would have to be waited for in turn;
// asked for a block of columns at a time, they come as fast as the disk can read. Memory used does
// not grow: a block's pages are read by the block right away.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "render/view/column_arrays.h"
#include "render/view/column_renderer.h"

namespace raywalk::render {

// One per thread: it owns scratch memory.
class ReadAhead {
 public:
  // The sources that an output column is rendered from.
  using SourcesOf = std::function<std::vector<RaySource>(int u)>;

  explicit ReadAhead(const ViewInputs& view);

  // Asks for what `count` output columns from `first` on (around the seam) read of the volumes, if
  // some of it is not in memory. Advice only: rendering does not depend on it.
  void fetch(int first, int count, const SourcesOf& sources_of);

 private:
  // Pages of one station's rays.
  using Pages = std::vector<bool>;

  bool in_memory(int u, std::span<const RaySource> sources) const;
  // Columns whose middle tells whether a station's part in output column u is in memory. An initial
  // view reads the column ahead; that a corrected one was rendered shows a quarter turn off.
  std::array<int, 2> looked_at(int u) const;
  void mark(int u, const RaySource& source, int station);
  void mark_rows(int column, int first_row, int end_row, Pages* pages) const;
  void mark_seen(Pages* pages);
  void fetch_marked() const;
  void fetch_pages(const LineVolume& volume, int station, const Pages& pages) const;
  size_t station_bytes() const;  // of its rays
  double theta_of(int u) const;
  // Where a captured panorama looks along an output column's direction.
  ColumnPosition ahead(int u) const;

  const ViewInputs& view_;
  PanoramaSize captured_;
  PolarColumns polar_;
  std::unique_ptr<LatitudeTable> latitudes_;  // of the distances' rows; null in an initial view
  std::unique_ptr<PositionArrays> positions_;
  std::map<std::pair<int, int>, Pages> marked_;  // by line and station
};

}  // namespace raywalk::render
