#include "core/view/column_rows.h"

#include <cmath>

namespace raywalk {
namespace {

// From a to b, 0 where they are of different surfaces.
RAYWALK_INLINE float change(float a, float b, float tolerance) {
  const float larger = a > b ? a : b;
  return std::fabs(a - b) > tolerance * larger ? 0.0f : b - a;
}

RAYWALK_INLINE float tame(float change, float wild) {
  return std::fabs(change) > wild ? 0.0f : change;
}

// So many output rows for each row of the distances.
template <int kPerRow>
RAYWALK_INLINE void interpolate_whole(const float* at, const float* joined, int rows, float wild,
                                      float* out) {
  for (int i = 0; i < rows; ++i) {
    const float up = joined[i - 1] * tame(at[i - 1] - at[i], wild);
    const float down = joined[i] * tame(at[i + 1] - at[i], wild);
    for (int k = 0; k < kPerRow; ++k) {
      const float from_middle = static_cast<float>(2 * k + 1 - kPerRow) / (2 * kPerRow);
      out[kPerRow * i + k] = at[i] + (from_middle < 0.0f ? -from_middle * up : from_middle * down);
    }
  }
}

template <int kPerRow>
RAYWALK_INLINE void repeat_whole(const float* at, int rows, float* out) {
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < kPerRow; ++k) out[kPerRow * i + k] = at[i];
  }
}

}  // namespace

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

RAYWALK_VECTOR_CLONES void interpolate_columns(const float* nearest, const float* other, int rows,
                                               float part, float tolerance, float* inverse) {
  for (int i = 0; i < rows; ++i) {
    inverse[i] = nearest[i] + part * change(nearest[i], other[i], tolerance);
  }
}

RAYWALK_VECTOR_CLONES void find_joined(const float* inverse, int begin, int end, float tolerance,
                                       float* joined) {
  for (int i = begin; i < end; ++i) {
    const float larger = inverse[i] > inverse[i + 1] ? inverse[i] : inverse[i + 1];
    joined[i] = std::fabs(inverse[i] - inverse[i + 1]) > tolerance * larger ? 0.0f : 1.0f;
  }
}

RAYWALK_VECTOR_CLONES void interpolate_rows(const float* at, const float* joined, RowsBetween rows,
                                            float wild, float* out) {
  const float *const from = at + rows.nearest[0], *const same_from = joined + rows.nearest[0];
  const int whole = rows.per_row == 0 ? 0 : rows.rows / rows.per_row;
  if (rows.per_row == 1) return repeat_whole<1>(from, whole, out);
  if (rows.per_row == 2) return interpolate_whole<2>(from, same_from, whole, wild, out);
  if (rows.per_row == 4) return interpolate_whole<4>(from, same_from, whole, wild, out);
  if (rows.per_row == 8) return interpolate_whole<8>(from, same_from, whole, wild, out);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows.rows; ++i) {
    const int row = rows.nearest[i];
    const float down = rows.down[i];
    const float beside = down < 0.0f ? at[row - 1] : at[row + 1];
    const float same = down < 0.0f ? joined[row - 1] : joined[row];
    out[i] = at[row] + (down < 0.0f ? -down : down) * same * tame(beside - at[row], wild);
  }
}

RAYWALK_VECTOR_CLONES void repeat_rows(const float* at, RowsBetween rows, float* out) {
  const float* const from = at + rows.nearest[0];
  if (rows.per_row == 1) return repeat_whole<1>(from, rows.rows, out);
  if (rows.per_row == 2) return repeat_whole<2>(from, rows.rows / 2, out);
  if (rows.per_row == 4) return repeat_whole<4>(from, rows.rows / 4, out);
  if (rows.per_row == 8) return repeat_whole<8>(from, rows.rows / 8, out);
  for (int i = 0; i < rows.rows; ++i) out[i] = at[rows.nearest[i]];
}

RAYWALK_VECTOR_CLONES void add_share(const std::uint8_t* occluded, StationOccluders by,
                                     const float* trust, StationShare share, int rows,
                                     float* weight, float* total) {
  // What no station seems to see counts after all, unless it is filled from another one.
  constexpr float kTrace = 1e-8f;
  for (int i = 0; i < rows; ++i) {
    const float doubt = trust == nullptr ? 0.0f : 1.0f - trust[i];
    const float here = share.reliable + (share.unreliable - share.reliable) * doubt;
    const float seen = seen_part(occluded[i], by);
    weight[i] = here * (seen + (1.0f - seen) * (doubt + kTrace));
    total[i] += weight[i];
  }
}

RAYWALK_VECTOR_CLONES bool normalise(const float* weight, const float* total, int rows,
                                     float* part) {
  constexpr float kNone = 1e-5f;  // less than a 16th of a level
  int any = 0;
  for (int i = 0; i < rows; ++i) {
    const float of = weight[i] / (total[i] > 1e-12f ? total[i] : 1e-12f);
    part[i] = of < kNone ? 0.0f : of;
    any |= static_cast<int>(part[i] > 0.0f);
  }
  return any != 0;
}

}  // namespace raywalk
