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

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "render/view/distance_view.h"
#include "render/view/row_pieces.h"
#include "render/view/row_table.h"
#include "render/view/view_options.h"
#include "render/view/view_plan.h"

namespace raywalk::render {

class TouchedRays;
struct RowSamples;

// What all columns of one view share. References must outlive the renderers.
struct ViewInputs {
  const Room& room;
  const ViewPlan& plan;
  PanoramaSize output;
  RowRun rows;  // that are wanted; others may be left as they are
  // The remaining members are for depth-corrected views; distances is null in an initial view.
  const DistanceView* distances = nullptr;
  std::optional<LayerSpacing> layers;  // none: correct by the exact distances
  Arithmetic arithmetic = Arithmetic::kFloat;
  // Where hidden pixels are looked for, nearest first.
  std::span<const MapStation> fill_maps;
  // As in ViewOptions.
  Interpolation interpolation = Interpolation::kLinear;
  int stations_mixed = 2;
  SecondSide second_side = SecondSide::kBlend;
  double skip_px = 0.0;
  TouchedRays* touched = nullptr;  // told what is read, where it is wanted
};

// Where output columns have 2, 4 or 8 times as many rows as the distances, positions are found at
// the distances' rows and interpolated: that number, else 1. Explicit layers, and double
// arithmetic, are exact to the pixel instead.
int rows_per_distance(const ViewInputs& view);

// Between which columns of a station such positions lie.
PolarColumns polar_columns_of(const ViewInputs& view);

// Work that was done and that was left out. A reading is one line's share in one pixel.
struct WorkCounts {
  std::int64_t samples = 0;      // read from stations
  std::int64_t found = 0;        // samples whose place had to be found; others are stored columns
  std::int64_t readings = 0;     // of lines in use
  std::int64_t uncorrected = 0;  // readings mixed as they are stored: their shift is too small
  std::int64_t one_station = 0;  // readings of one station: the other's share matters too little
  std::int64_t one_side = 0;     // pixels read from one side of the viewpoint though both see them

  WorkCounts& operator+=(const WorkCounts& other) {
    samples += other.samples;
    found += other.found;
    readings += other.readings;
    uncorrected += other.uncorrected;
    one_station += other.one_station;
    one_side += other.one_side;
    return *this;
  }
};

// What became of a column's pixels.
struct PixelCounts {
  std::int64_t all = 0;
  std::int64_t filled =
      0;  // hidden from the lines in use, read from another station that sees them
  std::int64_t stretched = 0;  // seen by no station: taken from the farther neighbour in the column
  std::int64_t empty = 0;      // no line serves the column, or nothing of it may be used: marked
  WorkCounts work{};

  PixelCounts& operator+=(const PixelCounts& other) {
    all += other.all;
    filled += other.filled;
    stretched += other.stretched;
    empty += other.empty;
    work += other.work;
    return *this;
  }
};

// Where the columns `step` apart, 2 or 4, are less than a row's height apart: within 30 and within
// 14.4 degrees of a pole, [0, begin) and [end, height) of what is returned. A picture loses nothing
// when what lies between two such columns there is their mean.
RowRun rows_between_polar_caps(int height, int step);

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
  // that are beyond rows_between_polar_caps(height, step); then it returns true, and the caller
  // takes their mean from the columns step / 2 to both sides.
  bool render_sparsely(int u, std::span<const RaySource> sources, int step, std::uint8_t* rgb);

  PixelCounts counts() const;

 private:
  struct Scratch;
  struct DepthColumn;

  // Output columns that are captured columns, mixed as they are.
  void mix_stored_columns(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
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
  void mix_source(int u, double theta_rad, const RaySource& source, RowRun rows, std::uint8_t* rgb);
  void blend_sources(int u, double theta_rad, std::span<const RaySource> sources, RowRun rows,
                     std::uint8_t* rgb);
  void add_source(int u, double theta_rad, const RaySource& source,
                  std::span<const std::int16_t> weights, RowRun rows);
  // A source counts the more the nearer its line is: alone when the viewpoint is on it.
  static double blend_share(std::span<const RaySource> sources, size_t which);

  // Rows that each source sees and is to be read in; without those that the parameters leave out.
  void look_from_sources(double theta_rad, int depth_theta, std::span<const RaySource> sources,
                         std::span<std::span<const std::uint8_t>> visible);
  void look_where_hidden(double theta_rad, int depth_theta, std::span<const RaySource> sources,
                         std::span<std::span<const std::uint8_t>> visible);
  void leave_side_out(double theta_rad, std::span<const RaySource> sources,
                      std::span<std::span<const std::uint8_t>> visible);
  // From where a source's ray crosses its line to the viewpoint, in the column's frame.
  ColumnOffset acquisition_offset(const RaySource& source, double theta_rad) const;
  int output_rows_of(size_t depth_row) const;

  // Whether a source may be read in some of its rows only.
  bool leaves_rows_out() const;
  // How a source is read where nothing is left out.
  Reading usual_reading(const RaySource& source) const;
  // The share of the station before (0) or after (1) the acquisition point, 1 in all.
  double station_share(const RaySource& source, int next) const;
  // The runs of `rows` in which a source is needed, and how they are read.
  std::span<const RowPiece> split_rows(int u, double theta_rad, const RaySource& source,
                                       RowRun rows);
  void choose_readings(int u, double theta_rad, const RaySource& source);
  void leave_station_out(double theta_rad, const RaySource& source);
  void leave_correction_out(int u, double theta_rad, const RaySource& source);
  void keep_near(ColumnOffset a, ColumnOffset b, double move_px);
  void read_near_rows(Reading reading);
  void mix_piece(int u, double theta_rad, const RaySource& source, const RowPiece& piece,
                 std::uint8_t* rgb);
  void add_piece(int u, double theta_rad, const RaySource& source, const RowPiece& piece,
                 std::span<const std::int16_t> weights);
  void count_readings(Reading reading, std::int64_t readings);
  // A run of rows of the plain cut; of one station twice where one is in use.
  struct StoredRows {
    std::array<const std::uint8_t*, 2> columns{};
    int count = 0;
    std::int16_t share = 0;  // of the second
  };
  StoredRows stored_rows(int u, const RaySource& source, RowRun rows);
  RowSamples samples_of(double theta_rad, const RaySource& source, const RowPiece& piece);
  // The samples of a run of output rows.
  StationSamples find_run(double theta_rad, const RaySource& source, int next, RowRun rows);
  StationSamples samples_at(int line, int station, SamplePositions positions) const;

  void snap_to_layers(const RaySource& source);
  StationSamples find_samples(double theta_rad, int line, int station, int first_row, int rows,
                              SamplePositions positions);
  // Where a column's plan direction lies in a captured panorama.
  ColumnTarget target_of(double theta_rad) const;
  // From a station to the viewpoint: in the world frame, and in the column's.
  Eigen::Vector3d displacement_from(int line, int station) const;
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
  // A row that was left out, if a source sees it.
  void render_row(int u, std::span<const RaySource> sources, int row, std::uint8_t* rgb);
  void mark_empty(int u, std::uint8_t* rgb);

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  std::unique_ptr<Scratch> scratch_;
  PixelCounts counts_;
};

}  // namespace raywalk::render
