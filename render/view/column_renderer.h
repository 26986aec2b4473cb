// Renders single columns of a view from the stations that its plan names.
//
// initial: the vertical cut, the pixel (theta, phi) of the panoramas around A, interpolated.
// hlf-vd: each pixel is read where A saw the point that the viewpoint sees: equation (5) on the
// whole great circle, solved for the source with the distance measured at the viewpoint, alpha =
// atan2(rho sin phi*, rho cos phi* - d_p). Each of the two stations around A is asked where it saw
// the point itself, so that near objects do not ghost. two-sided: the same from the lines in front
// and behind, each where it sees the point, weighted by the other's distance so that the picture is
// continuous when the viewpoint crosses a line.
//
// Rays that a station's mask hides (LineVolume::valid_rows) count as not seen by that station: the
// other lines and stations that see the point show it. An initial view, which knows no distances,
// stretches what is valid in the column.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "render/view/distance_view.h"
#include "render/view/row_table.h"
#include "render/view/view_plan.h"

namespace raywalk {

// What all columns of one view share. References must outlive the renderers.
struct ViewInputs {
  const Room& room;
  const ViewPlan& plan;
  PanoramaSize output;
  RowRun rows;  // that are wanted; others may be left as they are
  // The remaining members are for depth-corrected views; distances is null in an initial view.
  const DistanceView* distances = nullptr;
  std::optional<LayerSpacing> layers;  // none: correct by the exact distances
  // Where hidden pixels are looked for, nearest first.
  std::span<const MapStation> fill_maps;
};

// What became of a column's pixels.
struct PixelCounts {
  std::int64_t all = 0;
  std::int64_t filled =
      0;  // hidden from the lines in use, read from another station that sees them
  std::int64_t stretched = 0;  // seen by no station: taken from the farther neighbour in the column
  std::int64_t empty = 0;      // no line serves the column, or nothing of it may be used: marked
};

// Rows within 30 degrees of a pole: [0, begin) and [end, height) of what is returned. There columns
// are less than half a row's height apart, so that a picture loses nothing when every second one is
// the mean of its neighbours.
RowRun rows_between_polar_caps(int height);

// One per thread: it owns scratch memory and remembers the visibility of the last columns.
class ColumnRenderer {
 public:
  explicit ColumnRenderer(const ViewInputs& view);
  ~ColumnRenderer();
  ColumnRenderer(const ColumnRenderer&) = delete;
  ColumnRenderer& operator=(const ColumnRenderer&) = delete;

  // Renders output column `u` from the given lines into height * 3 rgb bytes, of which the wanted
  // rows are right; one byte beyond is scratch. With no sources the column is marked with a grey
  // pattern.
  void render(int u, std::span<const RaySource> sources, std::uint8_t* rgb);

  // The same, but in columns with more rows than their distances have it may leave out the rows
  // within 30 degrees of the poles (see rows_between_polar_caps); then it returns true, and the
  // caller takes their mean from the columns on both sides.
  bool render_sparsely(int u, std::span<const RaySource> sources, std::uint8_t* rgb);

  const PixelCounts& counts() const { return counts_; }

 private:
  struct Scratch;
  struct DepthColumn;

  void cut_column(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  // Valid rows of what an initial view reads of a station.
  RowRun rows_to_cut(int u, int line, int station) const;
  void render_initial(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  void render_corrected(int u, std::span<const RaySource> sources, RowRun rows, std::uint8_t* rgb);
  void prepare_omega(int u);
  void weigh_sources(double theta_rad, int depth_theta, std::span<const RaySource> sources);
  std::span<const std::uint8_t> visible_rows(int depth_theta, const RaySource& source);
  // visible_rows() but for those with a sample that is masked; `which` is the source's index.
  std::span<const std::uint8_t> usable_rows(double theta_rad, int depth_theta,
                                            const RaySource& source, size_t which);
  void mix_source(double theta_rad, const RaySource& source, RowRun rows, std::uint8_t* rgb);
  void blend_sources(double theta_rad, std::span<const RaySource> sources, std::uint8_t* rgb);
  void add_source(double theta_rad, const RaySource& source, std::span<const std::int16_t> weights);
  void snap_to_layers(const RaySource& source);
  StationSamples find_samples(double theta_rad, const RaySource& source, int next);
  StationSamples find_samples(double theta_rad, int line, int station, int first_row, int rows,
                              SamplePositions positions);
  // Where a column's plan direction lies in a captured panorama.
  ColumnTarget target_of(double theta_rad) const;
  // From a station to the viewpoint, in the column's frame.
  ColumnOffset offset_from(int line, int station, double theta_rad) const;
  Eigen::Vector3d viewpoint_m() const;
  void fill_hidden(double theta_rad, int depth_theta, std::uint8_t* rgb);
  int station_that_sees(int depth_theta, int depth_row);
  // Whether a station's mask leaves free what a pixel of the distances covers there.
  bool shows(const MapStation& map, const Eigen::Vector3f& direction, float omega) const;
  void leave_unresolved(RowRun run);
  // Rows [begin, end) that were filled from a station's masked rays after all, where the distances
  // between two rows differ from both.
  void leave_masked_unresolved(const MapStation& map, int begin, int end,
                               SamplePositions positions);
  // `rendered`: rows that were, where they are seen.
  void stretch_rest(int u, std::span<const RaySource> sources, RowRun rendered, std::uint8_t* rgb);
  // A row of a column with one source that was left out, if the source sees it.
  void render_row(int u, std::span<const RaySource> sources, int row, std::uint8_t* rgb);
  void mark_empty(int u, std::uint8_t* rgb);

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  std::unique_ptr<Scratch> scratch_;
  PixelCounts counts_;
};

}  // namespace raywalk
