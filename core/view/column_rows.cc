#include "core/view/column_rows.h"

#include <cmath>

#include "core/view/sampler.h"

namespace raywalk {

RAYWALK_VECTOR_CLONES void find_positions(const float* sin_phi, const float* cos_phi,
                                          const float* inverse, int rows, Offset to_eye,
                                          PanoramaSize captured, float* from_column, float* v) {
  const float per_turn = static_cast<float>(captured.width) / static_cast<float>(kTwoPi);
  const float per_phi = static_cast<float>(captured.height) / static_cast<float>(kPi);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    const SeenPoint seen = seen_from(sin_phi[i], cos_phi[i], inverse[i], to_eye);
    from_column[i] = seen.turn_rad * per_turn;
    v[i] = (static_cast<float>(kHalfPi) - seen.phi_rad) * per_phi - 0.5f;
  }
}

RAYWALK_VECTOR_CLONES void find_parts(const float* a, const float* b, int rows, float part,
                                      float tolerance, float* parts, float* inverse) {
  const float nearer = part < 0.5f ? 0.0f : 1.0f;
  for (int i = 0; i < rows; ++i) {
    const float larger = a[i] > b[i] ? a[i] : b[i];
    parts[i] = std::fabs(a[i] - b[i]) > tolerance * larger ? nearer : part;
    inverse[i] = a[i] + (b[i] - a[i]) * parts[i];
  }
}

RAYWALK_VECTOR_CLONES void find_steps(const float* inverse, int rows, float tolerance,
                                      float* step) {
  for (int i = 0; i + 1 < rows; ++i) {
    const float larger = inverse[i] > inverse[i + 1] ? inverse[i] : inverse[i + 1];
    step[i] = std::fabs(inverse[i] - inverse[i + 1]) > tolerance * larger ? 1.0f : 0.0f;
  }
}

RAYWALK_VECTOR_CLONES void between_columns(const float* a, const float* b, const float* part,
                                           int rows, float turn, float* out) {
  for (int i = 0; i < rows; ++i) {
    float step = b[i] - a[i];
    step -= step > 0.5f * turn ? turn : 0.0f;
    step += step < -0.5f * turn ? turn : 0.0f;
    out[i] = a[i] + step * part[i];
  }
}

namespace {

// The same number of output rows for each row of the distances: kPerRow. Between the middles of two
// rows are kPerRow output rows, the first of them after the middle of the upper one.
template <int kPerRow>
RAYWALK_INLINE void between_whole_rows(const float* at, const float* step, int intervals,
                                       float wild, float* out) {
  for (int i = 0; i < intervals; ++i) {
    const float change = at[i + 1] - at[i];
    const bool jumps = (step[i] != 0.0f) | (std::fabs(change) > wild);
    const float slope = jumps ? 0.0f : change / kPerRow;
    const float jump = jumps ? change : 0.0f;
    for (int k = 0; k < kPerRow; ++k) {
      out[kPerRow * i + k] =
          at[i] + slope * (static_cast<float>(k) + 0.5f) + (2 * k < kPerRow ? 0.0f : jump);
    }
  }
}

// Any number.
RAYWALK_INLINE void between_any_rows(const float* at, const float* step, RowsBetween rows,
                                     float wild, float* out) {
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows.rows; ++i) {
    const int row = rows.upper[i] - rows.first_upper;
    const float change = at[row + 1] - at[row];
    const float nearer = rows.part[i] < 0.5f ? 0.0f : 1.0f;
    const bool jumps = (step[row] != 0.0f) | (std::fabs(change) > wild);
    out[i] = at[row] + change * (jumps ? nearer : rows.part[i]);
  }
}

// The part of `rows` from row `first` on, `count` of them.
RAYWALK_INLINE RowsBetween part_of(RowsBetween rows, int first, int count) {
  return {rows.upper + first, rows.part + first, rows.first_upper, rows.per_row, count};
}

}  // namespace

RAYWALK_VECTOR_CLONES void between_rows(const float* at, const float* step, RowsBetween rows,
                                        float wild, float* out) {
  // The rows before the first whole interval between two rows of the distances.
  int before = 0;
  const bool whole = rows.per_row == 2 || rows.per_row == 4 || rows.per_row == 8;
  while (before < rows.rows &&
         (!whole || rows.part[before] * rows.per_row > 0.75f || rows.part[before] < 0.0f)) {
    ++before;
  }
  between_any_rows(at, step, part_of(rows, 0, before), wild, out);
  if (before == rows.rows) return;
  const int intervals = (rows.rows - before) / rows.per_row;
  const int row = rows.upper[before] - rows.first_upper;
  float* const from = out + before;
  if (rows.per_row == 2) between_whole_rows<2>(at + row, step + row, intervals, wild, from);
  if (rows.per_row == 4) between_whole_rows<4>(at + row, step + row, intervals, wild, from);
  if (rows.per_row == 8) between_whole_rows<8>(at + row, step + row, intervals, wild, from);
  const int done = before + intervals * rows.per_row;
  between_any_rows(at, step, part_of(rows, done, rows.rows - done), wild, out + done);
}

RAYWALK_VECTOR_CLONES void add_share(const std::uint8_t* occluded, StationOccluders by,
                                     const float* trust, StationShare share, int rows,
                                     float* weight, float* total) {
  // What no station seems to see counts after all, unless it is filled from another one.
  constexpr float kTrace = 1e-8f;
  for (int i = 0; i < rows; ++i) {
    const float doubt = trust == nullptr ? 0.0f : 1.0f - trust[i];
    const float here = share.reliable + (share.unreliable - share.reliable) * doubt;
    weight[i] = here * (is_seen(occluded[i], by) ? 1.0f : doubt + kTrace);
    total[i] += weight[i];
  }
}

RAYWALK_VECTOR_CLONES void normalise(const float* weight, const float* total, int rows,
                                     std::int16_t* part) {
  constexpr float kToNearest = 0.5f;  // before truncation
  for (int i = 0; i < rows; ++i) {
    const float one = static_cast<float>(kWeightOne) / (total[i] > 1e-12f ? total[i] : 1e-12f);
    part[i] = static_cast<std::int16_t>(weight[i] * one + kToNearest);
  }
}

}  // namespace raywalk
