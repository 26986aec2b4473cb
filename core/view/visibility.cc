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
      bin_(omega_.size()),
      leaves_gap_(omega_.size()),
      nearest_(omega_.size() + 2) {}

void RingVisibility::compute(const DistanceView& distances, int theta, AcquisitionPoint from,
                             std::vector<std::uint8_t>& visible) {
  // From a line in front, what lies behind the viewpoint is farther than anything on this side of
  // it in the same direction: it hides nothing. That holds at any height of the line, since all
  // between two points ahead of the viewpoint is ahead of it.
  points_ = from.d_p > 0.0f ? rows_ : 2 * rows_;
  const float* column = distances.column(theta);
  std::copy_n(column, rows_, omega_.begin());
  if (points_ > rows_) {
    const float* opposite = distances.opposite_column(theta);
    std::reverse_copy(opposite, opposite + rows_, omega_.begin() + rows_);
  }
  column_kernels().project_ring(ring_latitudes_.table(), omega_.data(), points_, 2 * rows_, from,
                                position_.data(), omega_from_line_.data());
  const float tolerance = distances.surface_tolerance();
  find_bins(tolerance);
  keep_nearest();
  visible.resize(static_cast<size_t>(rows_));
  for (size_t i = 0; i < visible.size(); ++i) {
    const float* around = nearest_.data() + bin_[i];
    const float nearest = std::max({around[0], around[1], around[2]});
    visible[i] = omega_from_line_[i] >= nearest * (1.0f - tolerance) ? 1 : 0;
  }
}

// Branchless, so that the compiler vectorises it.
void RingVisibility::find_bins(float tolerance) {
  const auto points = static_cast<size_t>(points_);
  const int turn = 2 * rows_;
  for (size_t i = 0; i < points; ++i) {
    const float row_above = position_[i] + 0.5f;  // not negative, so that truncation rounds
    const int row = static_cast<int>(row_above);
    bin_[i] = row < turn ? row : row - turn;
  }
  const auto leaves_gap = [&](size_t i, size_t before) {
    const float here = omega_from_line_[i];
    const float there = omega_from_line_[before];
    const float larger = here > there ? here : there;
    const int step = bin_[i] - bin_[before];
    return ((step > 1) | (step < -1)) & (std::fabs(here - there) <= tolerance * larger);
  };
  leaves_gap_[0] = points_ == turn && leaves_gap(0, points - 1) ? 1 : 0;
  for (size_t i = 1; i < points; ++i) leaves_gap_[i] = leaves_gap(i, i - 1) ? 1 : 0;
}

void RingVisibility::keep_nearest() {
  std::fill(nearest_.begin(), nearest_.end(), 0.0f);
  float* const nearest = nearest_.data() + 1;
  const auto points = static_cast<size_t>(points_);
  for (size_t i = 0; i < points; ++i) {
    float& kept = nearest[bin_[i]];
    kept = std::max(kept, omega_from_line_[i]);
    if (leaves_gap_[i] != 0) fill_gap(i, i == 0 ? points - 1 : i - 1);
  }
  // A bin beyond each end, so that every bin has neighbours.
  nearest_.front() = nearest[2 * rows_ - 1];
  nearest_.back() = nearest[0];
}

// A surface nearer to A than to P covers more bins than it has points.
void RingVisibility::fill_gap(size_t i, size_t before) {
  const int turn = 2 * rows_;
  const float omega = std::min(omega_from_line_[i], omega_from_line_[before]);
  int step = bin_[i] - bin_[before];
  if (step > rows_) step -= turn;
  if (step < -rows_) step += turn;
  const int towards = step < 0 ? -1 : 1;
  for (int gap = towards; gap != step; gap += towards) {
    const int bin = (bin_[before] + gap + turn) % turn;
    float& kept = nearest_[static_cast<size_t>(bin) + 1];
    kept = std::max(kept, omega);
  }
}

}  // namespace raywalk
