// The inner loops of rendering: each works on one column and touches contiguous memory only.
// Every loop is compiled twice, for the baseline processor and for AVX2, and picked at run time;
// both use the same arithmetic, without fused multiply-add and in the same fixed point, so that a
// picture does not depend on the machine.
//
// Notation: a column frame has the axes forward (the plan direction of the column), up, and side
// (to the right, towards growing theta). omega is the inverse distance 1/rho from the viewpoint, so
// that points at infinity (omega = 0) need no special case: with o = viewpoint - station, the
// direction from a station to the point seen at latitude phi is (cos phi + omega o_forward, sin phi
// + omega o_up, omega o_side), up to a positive factor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/geometry/sphere.h"
#include "core/room/polar_columns.h"

namespace raywalk {

// A displacement in a column frame, metres.
struct ColumnOffset {
  float forward = 0.0f;
  float up = 0.0f;
  float side = 0.0f;
};

// Where the line of a source crosses the vertical plane of a column, as seen from the viewpoint.
struct AcquisitionPoint {
  float d_p = 0.0f;  // ahead in the plan, metres; negative: behind
  float up = 0.0f;   // metres
};

// Size of the source panorama and the position of the column's plan direction in it: column
// `u_whole` plus `u_part` in [0, 1).
struct ColumnTarget {
  int width = 0;
  int height = 0;
  int u_whole = 0;
  float u_part = 0.0f;
  RayLayout rays{};  // used by place_shifted only
};

// Prefetch distance of samples, rows.
inline constexpr int kSampleLookAhead = 64;

// A weight in [0, 32767] stored in both halves of a 32-bit value, and the weight of such a value.
constexpr std::int32_t twice_weight(int weight) { return weight * 0x10001; }
constexpr int weight_of(std::int32_t twice) { return twice & 0x7fff; }

// Where each row of an output column is read in one station: byte offsets of the upper pixels of
// the left and right column, and the interpolation weights in 1/32768, each in both halves of a
// value (twice_weight), so that loading it fills a register. The offset arrays have rows +
// kSampleLookAhead values; the last kSampleLookAhead are prefetched but not used.
struct SamplePositions {
  std::int32_t* offset_left = nullptr;
  std::int32_t* offset_right = nullptr;
  std::int32_t* weight_right = nullptr;
  std::int32_t* weight_lower = nullptr;
};

// Bytes of one column and of all columns of a station's rays.
struct RayExtent {
  std::int32_t column_bytes = 0;
  std::int32_t bytes = 0;
};

// The positions of rows `count` further on.
inline SamplePositions rows_from(SamplePositions positions, int count) {
  return {positions.offset_left + count, positions.offset_right + count,
          positions.weight_right + count, positions.weight_lower + count};
}

// From the least to the most of some offsets; none where most < least.
struct OffsetRange {
  std::int32_t least = 0;
  std::int32_t most = -1;
};

// Of the left and of the right pixels of kRowsPerExtent rows, or of fewer at a column's end.
inline constexpr int kRowsPerExtent = 32;
struct OffsetExtent {
  OffsetRange left;
  OffsetRange right;
};

// A station's rays and the positions of a column's samples in them. The two bytes before `rays`
// must be readable (in a volume the file header precedes them).
struct StationSamples {
  const std::uint8_t* rays = nullptr;
  SamplePositions positions;
  RayExtent extent{};  // used by cubic samples only
};

// Samples of two neighbouring stations, mixed first + (second - first) * share / 32768, with a
// weight in 1/32768 for every so many rows of the column.
struct WeightedPair {
  StationSamples first;
  StationSamples second;
  std::int16_t share = 0;
  const std::int16_t* weight = nullptr;
};

// Directions along a straight line of a flat picture, in the world frame, of any nonzero length:
// start + i * step for i = 0, 1, ...
struct RayLine {
  float start[3] = {0.0f, 0.0f, 1.0f};
  float step[3] = {0.0f, 0.0f, 0.0f};
};

// Consecutive columns of a panorama, wrapping around its seam: [column][row][rgb] in memory.
struct ColumnBlock {
  PanoramaSize panorama{};
  int first = 0;    // first column of the block in the panorama
  int columns = 0;  // up to all of them
};

// Latitudes of a column's rows.
struct RowTable {
  const float* sin_phi = nullptr;
  const float* cos_phi = nullptr;
};

// Readable values required after the last shift, for vector loads.
inline constexpr int kShiftPadding = 8;

// Results of find_shifts for rows from `first` on, of `rows` in total. Each row covers `per_row`
// (2, 4 or 8) output rows. The shift of an output row is interpolated between the rows above and
// below it; where there is nothing between these (no_between -1, else 0) and in the first and last
// per_row / 2 output rows, at the poles, it is the nearest one. The arrays have kShiftPadding
// values beyond those found, of any content.
struct ShiftedRows {
  const float* u = nullptr;
  const float* v = nullptr;
  const std::int32_t* no_between = nullptr;
  int first = 0;
  int rows = 0;
  int per_row = 8;
};

// Points of a distance map's column as the viewpoint sees them, with the pixels that each covers in
// the viewpoint's panorama; all arrays hold one value per row. A point that is unknown or inside
// the circle of eyes covers none, nor does one whose footprint contains no pixel centre: its last
// column or row is less than its first.
struct ProjectedPoints {
  float* omega = nullptr;  // inverse distance from the viewpoint, 1/m; -1 where it covers none
  float* u = nullptr;      // the point's own position, pixels
  float* v = nullptr;
  float* widening = nullptr;             // size of its pixel there relative to the map,
  float* magnification = nullptr;        // in columns and in rows
  std::int32_t* first_column = nullptr;  // in [-width, 2 * width): to be wrapped
  std::int32_t* last_column = nullptr;
  std::int32_t* first_row = nullptr;  // may lie outside [0, height)
  std::int32_t* last_row = nullptr;
  // Most points cover one or two columns and rows: the indices in [column][row] of the upper pixels
  // of the first and the second column, and how many rows further down the lower ones are, 0 or 1.
  // Pixels may be the same; where none is covered, any.
  std::int32_t* left = nullptr;
  std::int32_t* right = nullptr;
  std::int32_t* down = nullptr;
  std::int32_t* is_wide = nullptr;  // 1 where more are covered
};

// Depth layers equally spaced in inverse distance from the acquisition point: layer j = 0, 1, ...
// has omega_min + (j + 0.5) * step. Points nearer than the range that the layers were computed for
// use further layers of the same spacing.
struct LayerSpacing {
  float omega_min = 0.0f;
  float step = 0.0f;
};

// Largest shift of a point in a panorama, as the tangents of the angles between its columns and
// between its rows; both positive.
struct MoveLimit {
  float tan_theta = 0.0f;
  float tan_phi = 0.0f;
};

// Reads samples at given positions with one interpolation method. Sums, weights and output are as
// in ColumnKernels' functions of the same names, which interpolate linearly.
struct SampleReaders {
  void (*mix_pair)(StationSamples first, StationSamples second, std::int16_t share, int rows,
                   std::uint8_t* rgb);
  void (*accumulate_pair)(StationSamples first, StationSamples second, std::int16_t share,
                          const std::int16_t* weight, int rows, std::int16_t* sum);
  void (*sample_each)(StationSamples samples, int count, std::uint8_t* rgb);
  // accumulate_pair of one station alone.
  void (*accumulate_each)(StationSamples samples, const std::int16_t* weight, int rows,
                          std::int16_t* sum);
};

struct ColumnKernels {
  const char* name;

  // out = left + (right - left) * fraction where both are on one surface (they differ by at most
  // `tolerance` relative to the larger), else the value of the column nearer in position.
  void (*mix_omega)(const float* left, const float* right, float fraction, int rows,
                    float tolerance, float* out);

  // out = in, resampled along the column by the same rule between in[row] and in[row + 1].
  void (*upsample_omega)(const float* in, const int* row, const float* fraction, int rows,
                         float tolerance, float* out);

  // Replaces each omega by that of the nearest depth layer, measured from an acquisition point; a
  // direction whose ray from the viewpoint never meets the layer keeps its omega.
  void (*snap_to_layers)(RowTable table, int rows, AcquisitionPoint from, LayerSpacing layers,
                         float* omega);

  // Positions where a station at `offset` (viewpoint - station) saw the points of a column.
  void (*find_samples)(RowTable table, const float* omega, int rows, ColumnOffset offset,
                       ColumnTarget target, SamplePositions positions);

  // The same in two steps, for columns with several times as many rows as their distances. Of the
  // distances' `rows` rows, [first, first + count) are used: arrays and table begin at row `first`.
  // First the shift in columns and rows at which a station saw each row's point ...
  void (*find_shifts)(RowTable table, const float* omega, int first, int count, int rows,
                      ColumnOffset offset, ColumnTarget target, float* shift_u, float* shift_v);
  // ... and where there is nothing between a row's point and the next one's: -1 at an edge, where
  // they are not on one surface (as in mix_omega; rows + 1 values are read), ...
  void (*find_edges)(const float* omega, int rows, float tolerance, std::int32_t* edge);
  // ... or where a station saw them on different sides of a pole (count + 1 shifts are read); else
  // 0.
  void (*add_jumps)(const float* shift_u, const float* shift_v, int count, ColumnTarget target,
                    const std::int32_t* edge, std::int32_t* no_between);
  // Then the sample positions of output rows [begin, end), from the shifts of the rows around each.
  void (*place_shifted)(ShiftedRows shifted, int begin, int end, ColumnTarget target,
                        SamplePositions positions);

  // Adds bilinear samples of two neighbouring stations, mixed first + (second - first) * share /
  // 32768, to a column's sums: sum[4 row + c] += weight[row] / 32768 * 64 * sample, c = red, green,
  // blue. Rows of weight 0 are not read.
  void (*accumulate_pair)(StationSamples first, StationSamples second, std::int16_t share,
                          const std::int16_t* weight, int rows, std::int16_t* sum);

  // The same without sums, for rows read from one line only. Writes one byte beyond the column.
  void (*mix_pair)(StationSamples first, StationSamples second, std::int16_t share, int rows,
                   std::uint8_t* rgb);

  // Rows [begin, end) of a column mixed from `count` pairs, whose positions begin with row `begin`;
  // row i has the weight of index i / rows_per_weight (1, 2, 4 or 8). Rows of weight 0 are not
  // read; without any weight a row is black. Writes one byte beyond the rows.
  void (*mix_weighted)(const WeightedPair* pairs, int count, int begin, int end,
                       int rows_per_weight, std::uint8_t* rgb);

  // Positions of the directions of a line in a block of columns. Directions outside the block get
  // some position in it.
  void (*aim)(RayLine line, int count, ColumnBlock block, SamplePositions positions);

  // Bilinear samples of one station, or of one block: rgb, one byte beyond the last is written.
  void (*sample_each)(StationSamples samples, int count, std::uint8_t* rgb);

  // rgb[3 row + c] = sum[4 row + c] / 64, rounded. Writes one byte beyond the column.
  void (*finish)(const std::int16_t* sum, int rows, std::uint8_t* rgb);

  // out[i] = weighted mean of byte i of `count` columns, weights in 1/32768; count is 2 or 4.
  void (*mix_columns)(const std::uint8_t* const* columns, const std::int16_t* weights, int count,
                      int bytes, std::uint8_t* out);

  // Projects a distance map's column (inverse distances omega_map, negative where unknown, offset =
  // map's station - viewpoint) into the viewpoint's panorama of the size that `target` names. With
  // an `eye_radius` other than 0 each point is seen from the circle around the viewpoint, as
  // EyeCircle::direction_of has it, and its inverse distance is that from there.
  void (*project_points)(RowTable table, const float* omega_map, int rows, ColumnOffset offset,
                         float eye_radius, ColumnTarget target, ProjectedPoints points);

  // Follows the rays of a column into a distance map (inverse distances omega_map, [column][row], <
  // 0 where unknown; offset = viewpoint - map's station) and corrects omega, known to about a
  // pixel, by the map's value there on the same surface: to first order rho scales with the
  // distance.
  void (*refine_omega)(RowTable table, const float* omega, int rows, ColumnOffset offset,
                       ColumnTarget target, const float* omega_map, float tolerance,
                       float* refined);

  // Where a distance map (as in refine_omega) sees the points of a column: their inverse distances
  // from the map's station, and the indices of the upper pixels to the left and to the right of
  // their directions; the lower ones follow.
  void (*look_up_points)(RowTable table, const float* omega, int rows, ColumnOffset offset,
                         ColumnTarget target, float* omega_there, std::int32_t* left,
                         std::int32_t* right);

  // Copies `count` columns of rgb, `column_bytes` apart, into rows of a bgr image. The four bytes
  // after each column must be readable.
  void (*write_rows)(const std::uint8_t* columns, std::size_t column_bytes, int count, int rows,
                     std::uint8_t* image, std::size_t row_bytes);

  // Points of the great circle of a column as seen from an acquisition point: ring position
  // (counted from the zenith down the column and up the opposite one, in [-0.5, ring_rows - 0.5),
  // ring_rows twice the rows of a column) and inverse distance from there. The tables hold `points`
  // entries.
  void (*project_ring)(RowTable ring, const float* omega, int points, int ring_rows,
                       AcquisitionPoint from, float* position, float* omega_from_line);

  // Nearest neighbour: the pixel whose centre is nearest (halfway: the right, the lower).
  SampleReaders nearest;
  SampleReaders linear;
  // Samples of the 4 x 4 pixels around, weighted by Keys' cubic with a = -1/2, which is exact where
  // levels are quadratic in rows and in columns; fractions of a pixel are rounded to 1/1024.
  // Columns continue around the seam; beyond a pole its own row is repeated. Levels may overshoot
  // and are clamped at the end.
  SampleReaders cubic;

  // near[row] = 0 unless two stations (offsets viewpoint - station; 0 is the viewpoint itself) see
  // a row's point less than `limit` apart; unchanged elsewhere.
  void (*keep_near)(RowTable table, const float* omega, int rows, ColumnOffset a, ColumnOffset b,
                    MoveLimit limit, std::uint8_t* near);

  // accumulate_pair for two columns as they are stored, 3 * rows bytes each.
  void (*accumulate_stored)(const std::uint8_t* first, const std::uint8_t* second,
                            std::int16_t share, const std::int16_t* weight, int rows,
                            std::int16_t* sum);

  // Weights of `count` lines in each row, in 1/32768: in proportion to shares[k] * visible[k][row],
  // 32767 in all; 0 where none sees the row. `most` is the largest visible[k][row] and `seeing` how
  // many are not 0; `scale` is scratch of `rows` values.
  void (*weigh_rows)(const std::uint8_t* const* visible, const float* shares, int count, int rows,
                     std::int16_t* const* weights, std::uint8_t* most, std::uint8_t* seeing,
                     float* scale);

  // The extents of `rows` positions, block by block from the first on.
  void (*find_extents)(SamplePositions at, int rows, OffsetExtent* extents);
};

// The fastest kernels this processor can run.
const ColumnKernels& column_kernels();

// Kernels by name ("generic", "avx2"); null where the processor lacks them.
const ColumnKernels* column_kernels_named(const char* name);

}  // namespace raywalk
