// Reading ahead from the disk. A view reads neighbouring columns of each station and, of the rows
// near the poles, its polar part (polar_part.h). Where they are not in memory yet, as after opening
// a room, rendering would wait for one page after the other. Requested for a block of columns at a
// time, they arrive as fast as the disk can read. Memory use does not grow: the block reads its
// pages right away.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/view/column_arrays.h"
#include "core/view/column_renderer.h"

namespace raywalk {

// Bytes [begin, end) of the rays of one station, counted from the station's first column on.
struct RayBytes {
  int line = 0;  // index into Grid::lines
  int station = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

// One per thread: it owns scratch memory.
class ReadAhead {
 public:
  // The sources that output column u is rendered from.
  using SourcesOf = std::function<std::vector<RaySource>(int u)>;

  // `view` must outlive this.
  explicit ReadAhead(const ViewInputs& view);

  // Asks the system to read what `count` output columns from `first` on (around the seam) need of
  // the volumes, if some of it is not in memory. Advice only: rendering does not depend on it.
  void fetch(int first, int count, const SourcesOf& sources_of);

  // What fetch() asks for where nothing is in memory: whole pages of 4096 bytes, in order of line,
  // station and byte.
  std::vector<RayBytes> bytes_to_fetch(int first, int count, const SourcesOf& sources_of);

 private:
  // Pages of one station's rays.
  using Pages = std::vector<bool>;

  bool in_memory(int u, std::span<const RaySource> sources) const;
  // Columns whose middle row is checked to decide whether a station's share of output column u is
  // in memory. An initial view reads the column straight ahead; a corrected view also reads columns
  // a quarter turn away, which nothing else brings into memory.
  std::array<int, 2> checked_columns(int u) const;
  void mark(int u, const RaySource& source, int station);
  void mark_rows(int column, int first_row, int end_row, Pages* pages) const;
  void mark_bytes(std::size_t begin, std::size_t end, Pages* pages) const;
  void mark_positions(const RayLayout& layout, Pages* pages);
  void append_runs(int line, int station, const Pages& pages, std::vector<RayBytes>* runs) const;
  std::size_t station_bytes(int line) const;  // of its rays, with their polar part
  // Bytes from the start of the page that holds a station's first ray to that ray.
  std::size_t lead_of(int line, int station) const;
  double theta_of(int u) const;
  // The column of a captured panorama that looks in an output column's direction.
  ColumnPosition ahead(int u) const;

  const ViewInputs& view_;
  PanoramaSize captured_;
  std::unique_ptr<LatitudeTable> latitudes_;  // of the distances' rows; null in an initial view
  std::unique_ptr<PositionArrays> positions_;
  std::map<std::pair<int, int>, Pages> marked_;  // by line and station
  std::size_t lead_ = 0;                         // of the station that is being marked
};

}  // namespace raywalk
