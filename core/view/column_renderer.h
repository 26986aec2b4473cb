// Renders single columns of a view from the stations of its plan.
//
// initial: the vertical cut, the pixel (theta, phi) of the panoramas around A, interpolated.
// hlf-vd: each pixel is read where A saw the point that the viewpoint sees: equation (5) on the
// whole great circle, solved for the source with the distance measured at the viewpoint, alpha =
// atan2(rho sin phi*, rho cos phi* - d_p). The position is computed for each of the two stations
// around A separately, so that near objects do not ghost. two-sided: the same from the lines in
// front and behind, each where it sees the point, weighted by the other's distance so that the
// picture is continuous when the viewpoint crosses a line.
// Rays masked in a station (outside LineVolume::valid_rows) count as not seen by it: the point is
// read from other lines and stations that see it. Where the distances cannot be relied on, a line
// is not left out because it does not seem to see a point. An initial view, which has no distances,
// stretches the valid rows of the column instead. What no station sees is stretched too, until the
// finished picture is filled (picture_fill.h).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "core/view/distance_view.h"
#include "core/view/row_pieces.h"
#include "core/view/row_table.h"
#include "core/view/view_options.h"
#include "core/view/view_plan.h"

namespace raywalk {

class RoomGains;
class TouchedRays;
struct RowSamples;
struct StationShare;

// Input shared by all columns of a view. References must outlive the renderers.
struct ViewInputs {
  const Room& room;
  const ViewPlan& plan;
  PanoramaSize output;
  RowRun rows;  // rows to render; others may be left unchanged
  // The remaining members are for depth-corrected views; distances is null in an initial view.
  const DistanceView* distances = nullptr;
  std::optional<LayerSpacing> layers;  // none: correct by the exact distances
  Arithmetic arithmetic = Arithmetic::kFloat;
  // Stations that hidden pixels are filled from, nearest first.
  std::span<const MapStation> fill_maps;
  // As in ViewOptions.
  Interpolation interpolation = Interpolation::kLinear;
  int stations_mixed = 2;
  SecondSide second_side = SecondSide::kBlend;
  double skip_px = 0.0;
  const RoomGains* gains = nullptr;  // null: all are 1
  TouchedRays* touched = nullptr;    // counts the bytes read; null: not counted
};

// Output rows per row of the distances where sample positions are computed at the distances' rows
// and interpolated between them: 2, 4 or 8. Else 1: every row's position is computed, as always
// with explicit layers or double arithmetic.
int rows_per_distance(const ViewInputs& view);

// The columns of a station that such interpolated positions lie between.
PolarColumns polar_columns_of(const ViewInputs& view);

// Counts of work done and skipped. A reading is one line's share of one pixel.
struct WorkCounts {
  std::int64_t samples = 0;      // read from stations
  std::int64_t found = 0;        // samples at a computed position; the others are stored columns
  std::int64_t readings = 0;     // of lines in use
  std::int64_t uncorrected = 0;  // readings without correction: their shift is too small
  std::int64_t one_station = 0;  // readings of one station: the other's influence is too small
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

// Counts of pixels by how they were rendered.
struct PixelCounts {
  std::int64_t all = 0;
  std::int64_t filled = 0;     // hidden from the lines in use, read from another station
  std::int64_t stretched = 0;  // seen by no station: taken from the farther neighbour in the column
  std::int64_t empty = 0;      // no line serves the column, or all of it is masked
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

// The rows outside the polar caps. In the caps, [0, begin) and [end, height), columns `step` (2 or
// 4) apart are less than a row's height apart: within 30 (step 2) or 14.4 degrees (step 4) of a
// pole. There the columns between two such columns can be their mean without visible loss.
RowRun rows_between_polar_caps(int height, int step);

// One per thread: it owns scratch memory and remembers the visibility of the last columns.
class ColumnRenderer {
 public:
  explicit ColumnRenderer(const ViewInputs& view);
  ~ColumnRenderer();
  ColumnRenderer(const ColumnRenderer&) = delete;
  ColumnRenderer& operator=(const ColumnRenderer&) = delete;

  // Renders output column `u` from the given lines into height * 3 rgb bytes. Only the rows of
  // ViewInputs::rows are valid; one byte beyond is scratch. Without sources the column shows what
  // other stations see, else a grey pattern.
  void render(int u, std::span<const RaySource> sources, std::uint8_t* rgb);

  // The same, but in columns with more rows than their distances it may skip the polar caps outside
  // rows_between_polar_caps(height, step). It then returns true, and the caller fills them with the
  // mean of the columns step / 2 to both sides.
  bool render_sparsely(int u, std::span<const RaySource> sources, int step, std::uint8_t* rgb);

  // The rows of the last column that no station shows. What they hold, a neighbour's colour or the
  // grey pattern, stands in for what the rest of the picture tells (picture_fill.h).
  std::span<const RowRun> unknown_rows() const;

  PixelCounts counts() const;

 private:
  struct Scratch;
  struct DepthColumn;

  static constexpr std::uint8_t kSeen = 255;
  static constexpr size_t kMaxSources = 4;  // two in front and two behind

  // Output columns that coincide with captured columns: mixed without resampling.
  void mix_stored_columns(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  void render_cut(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  // Valid rows of the columns of a station that an initial view reads.
  RowRun valid_rows_of_cut(int u, int line, int station) const;
  void render_initial(int u, std::span<const RaySource> sources, std::uint8_t* rgb);
  void render_corrected(int u, std::span<const RaySource> sources, RowRun rows, std::uint8_t* rgb);
  // A column without sources: what other stations see of it.
  void render_unserved(int u, std::uint8_t* rgb);
  // The column of the distances nearest to a direction.
  int depth_column(double theta_rad) const;
  // Forgets what is known of another column of the distances.
  void begin_depth_column(int depth_theta);
  void prepare_omega(int u);
  void weigh_sources(double theta_rad, int depth_theta, std::span<const RaySource> sources);
  // From how well the best source sees each row.
  void find_hidden(std::span<const std::uint8_t> seen);
  // How well a source sees the rows of the distances, 0 to kSeen.
  std::span<const std::uint8_t> visible_rows(int depth_theta, const RaySource& source);
  // Sets visible[row] = 0 where a station of the source does not see the point and another one
  // does.
  void remove_hidden_from_stations(int depth_theta, const RaySource& source,
                                   std::vector<std::uint8_t>& visible);
  // A line that does not seem to see a point is not used for it; the less the distances can be
  // relied on (`trust`, null: entirely), the more it is used after all.
  static void weigh_visibility(const float* trust, std::span<std::uint8_t> rows);
  // visible_rows() without those whose samples are masked or left out; `which` is the source's
  // index.
  std::span<const std::uint8_t> usable_rows(double theta_rad, int depth_theta,
                                            const RaySource& source, size_t which);
  void mix_source(int u, double theta_rad, const RaySource& source, RowRun rows, std::uint8_t* rgb);
  void blend_sources(int u, double theta_rad, std::span<const RaySource> sources, RowRun rows,
                     std::uint8_t* rgb);
  // Whether all sources are mixed in one go: nothing is skipped or multiplied by gains.
  bool mixes_in_registers(std::span<const RaySource> sources) const;
  void mix_weighted(double theta_rad, std::span<const RaySource> sources, RowRun rows,
                    std::uint8_t* rgb);
  std::int64_t rows_with_weight(std::span<const std::int16_t> weights, RowRun rows) const;
  void add_source(int u, double theta_rad, const RaySource& source,
                  std::span<const std::int16_t> weights, RowRun rows);
  // Weight of a source: inversely proportional to the distance of its line, so that a line through
  // the viewpoint is used alone.
  static double blend_share(std::span<const RaySource> sources, size_t which);

  // The rows that each source sees, without those that the options skip.
  void find_visible_rows(double theta_rad, int depth_theta, std::span<const RaySource> sources,
                         std::span<std::span<const std::uint8_t>> visible);
  void read_second_side_where_hidden(double theta_rad, int depth_theta,
                                     std::span<const RaySource> sources,
                                     std::span<std::span<const std::uint8_t>> visible);
  void skip_second_side(double theta_rad, std::span<const RaySource> sources,
                        std::span<std::span<const std::uint8_t>> visible);
  // From the acquisition point of a source to the viewpoint, in the column's frame.
  ColumnOffset acquisition_offset(const RaySource& source, double theta_rad) const;
  int output_rows_of(size_t depth_row) const;

  // Whether the options may skip some rows of a source.
  bool skips_rows() const;
  // How a source is read where nothing is skipped.
  Reading usual_reading(const RaySource& source) const;
  // The share of the station before (0) or after (1) the acquisition point, 1 in all.
  double station_share(const RaySource& source, int next) const;
  // The runs of `rows` in which a source is read, and how.
  std::span<const RowPiece> split_rows(int u, double theta_rad, const RaySource& source,
                                       RowRun rows);
  void choose_readings(int u, double theta_rad, const RaySource& source);
  void skip_second_station(double theta_rad, const RaySource& source);
  void skip_correction(int u, double theta_rad, const RaySource& source);
  void keep_near(ColumnOffset a, ColumnOffset b, double move_px);
  void read_near_rows(Reading reading);
  void mix_piece(int u, double theta_rad, const RaySource& source, const RowPiece& piece,
                 std::uint8_t* rgb);
  void add_piece(int u, double theta_rad, const RaySource& source, const RowPiece& piece,
                 std::span<const std::int16_t> weights);
  void count_readings(Reading reading, std::int64_t readings);
  // A run of rows of the plain cut; the same station twice where only one is used.
  struct StoredRows {
    std::array<const std::uint8_t*, 2> columns{};
    std::array<int, 2> stations{};
    int count = 0;
    std::int16_t share = 0;  // of the second
  };
  StoredRows stored_rows(int u, const RaySource& source, RowRun rows);
  // Writes the rows, mixed and multiplied by their gains.
  void mix_stored(int u, const RaySource& source, const StoredRows& stored, RowRun rows,
                  std::uint8_t* rgb);
  static std::array<StationShare, 2> shares_of(const RaySource& source, const StoredRows& stored);
  RowSamples samples_of(double theta_rad, const RaySource& source, const RowPiece& piece);
  // The samples of a run of output rows.
  StationSamples find_run(double theta_rad, const RaySource& source, int next, RowRun rows);
  StationSamples find_run(double theta_rad, int line, int station, RowRun rows,
                          SamplePositions positions);
  StationSamples samples_at(int line, int station, SamplePositions positions) const;

  void snap_to_layers(const RaySource& source);
  StationSamples find_samples(double theta_rad, int line, int station, int first_row, int rows,
                              SamplePositions positions);
  // The position of a column's plan direction in a captured panorama.
  ColumnTarget target_of(double theta_rad) const;
  // From a station to the viewpoint: in the world frame, and in the column's.
  Eigen::Vector3d displacement_from(int line, int station) const;
  ColumnOffset offset_from(int line, int station, double theta_rad) const;
  Eigen::Vector3d viewpoint_m() const;
  void fill_hidden(double theta_rad, int depth_theta, std::uint8_t* rgb);
  // Shows a station in hidden rows of the output, each as far as it is hidden.
  void show_station(double theta_rad, const MapStation& map, RowRun rows, std::uint8_t* rgb);
  // Marks those of the rows that nothing else is shown in.
  void leave_unresolved(RowRun rows);
  // What no source sees of an output row, 0 to kSeen.
  std::uint8_t hidden_part(int row) const;
  int find_fill_station(int depth_theta, int depth_row);
  // The same, remembered for the current column of the distances.
  int fill_of(int depth_theta, int depth_row);
  // The same where the distances cannot be relied on.
  int find_unmasked_station(const Eigen::Vector3f& direction, float omega) const;
  // Whether the pixels of a station that a pixel of the distances covers are unmasked.
  bool is_unmasked(const MapStation& map, const Eigen::Vector3f& direction, float omega) const;
  // Whether one of the pixels of a station around a pixel of the distances is left out.
  bool is_left_out(const MapStation& map, const Eigen::Vector3f& direction, float omega) const;
  // Whether a station is shown in a hidden row although its pixels there are left out, as no other
  // station sees the place.
  bool shows_moved(const MapStation& map, int row) const;
  void add_unresolved(RowRun run);
  // `rendered`: the rows already rendered where they are visible.
  void stretch_unresolved(int u, std::span<const RaySource> sources, RowRun rendered,
                          std::uint8_t* rgb);
  // Renders a skipped row if a source sees it.
  void render_row(int u, std::span<const RaySource> sources, int row, std::uint8_t* rgb);
  void fill_empty(int u, std::uint8_t* rgb);

  const ViewInputs& view_;
  const ColumnKernels& kernels_;
  std::unique_ptr<Scratch> scratch_;
  PixelCounts counts_;
};

}  // namespace raywalk
