// Pass 4: the samples of the stations, mixed.
//
// A column of the output is read from the stations of its sources (column_sources.h). Its distances
// are interpolated between two columns of the distances, its points at their rows projected into
// each station, and the places of output rows interpolated between these, all where they show one
// surface. A station counts by its share among those that see the point; what none sees is read
// from the station that pass 2 or a search found (fill_stations.h). At an edge of the distances
// (edges.h) a pixel is the mean of this and of samples of its quarters: of all four where the
// output is about as fine as the distances, else of the one that it lies in.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <utility>
#include <vector>

#include "core/view/mixed_column.h"
#include "core/view/rendered_part.h"
#include "core/view/sampler.h"

namespace raywalk {

// One per thread: it owns scratch memory.
class StationMixing {
 public:
  static constexpr int kColumns = 64;  // at most, at once

  explicit StationMixing(const MixedView& view);
  ~StationMixing();

  // Renders `count` columns of the output from `first` on, around the seam, and rows [rows.begin,
  // rows.end), bgr, to `image` (CV_8UC3), whose upper left corner is that of the block.
  void render(int first, int count, RowRun rows, cv::Mat image);

  // What could not be read since the last call, and the counts since it.
  std::vector<UnreadRows> take_unread() { return std::exchange(unread_, {}); }
  PixelCounts take_counts() { return std::exchange(counts_, {}); }

 private:
  static constexpr int kRows = kMostRows;  // output rows of a tile, and samples at once
  static constexpr int kStride = 3 * kColumns + 16;

  using Read = ColumnRead;
  using Column = MixedColumn;
  // mixing_scratch.h has these.
  struct Points;
  struct PlacedStation;
  struct Placed;
  struct Scratch;

  // Rows of all columns, into Scratch::tile.
  void render_tile(int count, RowRun rows);
  // Places the samples of rows of a column in its stations.
  void place_rows(const Column& column, RowRun rows, Placed* placed);
  // Sets Scratch::inverse and joined of the rows of the distances around.
  void find_distances(const Column& column, const RowsBetween& rows);
  // In a further station, with Scratch::row_weight, between the places of these rows.
  void place_between(const Column& column, const RowsBetween& rows, const Read& read,
                     Placed* placed);
  // Places the samples of points in a further station, with `weight`.
  void place_points(const Points& points, const float* weight, const Read& read, Placed* placed);
  // Completes samples whose rows, and columns relative to a captured one, are in `station`.
  void finish(float column, const float* weight, int count, PlacedStation* station);
  // Mixes samples, without those that are masked; `next`: those that are mixed after them, or null.
  void mix(bool any_masks, int rows, Placed* placed, Placed* next, std::uint8_t* bgr, int stride);
  void remove_masked(int rows, Placed* placed);
  // Sets Scratch::weight of the reads of a column whose sources' points are occluded as told.
  void find_weights(const Column& column,
                    const std::array<const std::uint8_t*, kMaxSources>& occluded,
                    const float* trust, int count);

  // mixing_fill.cc: reads what no line sees from other stations.
  void fill_rows(const Column& column, RowRun rows, const float* total, std::uint8_t* bgr);
  void leave_masked(const Column& column, RowRun rows, const float* total, std::uint8_t* bgr);
  void leave_unread(const Column& column, RowRun rows, std::uint8_t* bgr);
  int station_to_show(const Column& column, int row, const float* total);
  void show_station(const Column& column, int station, RowRun rows, std::uint8_t* bgr);

  // mixing_initial.cc: initial views, which know no distances.
  bool shows_stored_columns() const;
  void place_cut(const Column& column, RowRun rows, Placed* placed);
  void mix_stored(const Column& column, RowRun rows, std::uint8_t* bgr);

  // mixing_edges.cc: reads the pixels at edges of the distances once more.
  void render_edges(const Column& column, RowRun rows, std::uint8_t* bgr);
  void sample_quarters(const Column& column, double u, std::span<const EdgeQuarter* const> quarters,
                       std::span<const float> rows);
  void find_shares(const Column& column, std::span<const EdgeQuarter* const> quarters,
                   std::span<const int> distance_rows);

  const MixedView& view_;
  std::unique_ptr<Scratch> scratch_;
  std::vector<UnreadRows> unread_;
  PixelCounts counts_;
};

}  // namespace raywalk
