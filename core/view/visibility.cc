#include "core/view/visibility.h"

#include <algorithm>
#include <cmath>

namespace raywalk {

RingVisibility::RingVisibility(int rows)
    : rows_(rows),
      ring_latitudes_(rows, 2 * rows),
      omega_(static_cast<size_t>(2 * rows)),
      position_(omega_),
      omega_from_line_(omega_),
      nearest_(omega_) {}

void RingVisibility::compute(const DistanceView& distances, int theta, double d_p_m,
                             std::vector<std::uint8_t>& visible) {
  const int ring_rows = 2 * rows_;
  const float* column = distances.column(theta);
  const float* opposite = distances.column((theta + rows_) % ring_rows);
  std::copy_n(column, rows_, omega_.begin());
  std::reverse_copy(opposite, opposite + rows_, omega_.begin() + rows_);
  column_kernels().project_ring(ring_latitudes_.table(), omega_.data(), ring_rows,
                                static_cast<float>(d_p_m), position_.data(),
                                omega_from_line_.data());
  const float tolerance = distances.surface_tolerance();
  std::fill(nearest_.begin(), nearest_.end(), 0.0f);
  const auto bin = [&](float position) {
    const float row_above = position + 0.5f;  // not negative, so that truncation rounds to nearest
    const int row = static_cast<int>(row_above);
    return row < ring_rows ? row : row - ring_rows;
  };
  const auto keep_nearest = [&](int row, float omega) {
    float& nearest = nearest_[static_cast<size_t>(row)];
    nearest = std::max(nearest, omega);
  };
  for (int i = 0; i < ring_rows; ++i) {
    const int previous = i == 0 ? ring_rows - 1 : i - 1;
    const float here = omega_from_line_[static_cast<size_t>(i)];
    const float before = omega_from_line_[static_cast<size_t>(previous)];
    keep_nearest(bin(position_[static_cast<size_t>(i)]), here);
    // A surface nearer to A than to P covers more rows than it has samples: fill the gaps.
    float step = position_[static_cast<size_t>(i)] - position_[static_cast<size_t>(previous)];
    if (step > rows_) step -= static_cast<float>(ring_rows);
    if (step < -rows_) step += static_cast<float>(ring_rows);
    if (std::fabs(step) <= 1.0f) continue;
    if (std::fabs(here - before) > tolerance * std::max(here, before)) continue;
    const int gaps = static_cast<int>(std::fabs(step));
    for (int gap = 1; gap <= gaps; ++gap) {
      float position = position_[static_cast<size_t>(previous)] +
                       step * static_cast<float>(gap) / static_cast<float>(gaps + 1);
      if (position < -0.5f) position += static_cast<float>(ring_rows);
      keep_nearest(bin(position), std::min(here, before));
    }
  }
  visible.resize(static_cast<size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    const auto i = static_cast<size_t>(row);
    const int at = bin(position_[i]);
    const int before = at == 0 ? ring_rows - 1 : at - 1;
    const int after = at + 1 == ring_rows ? 0 : at + 1;
    const auto nearest_at = [&](int ring_row) { return nearest_[static_cast<size_t>(ring_row)]; };
    const float nearest = std::max({nearest_at(before), nearest_at(at), nearest_at(after)});
    visible[i] = omega_from_line_[i] >= nearest * (1.0f - tolerance) ? 1 : 0;
  }
}

}  // namespace raywalk
