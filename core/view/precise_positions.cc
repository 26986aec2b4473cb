#include "core/view/precise_positions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace raywalk {
namespace {

// Positions are multiples of 1/32768 pixel.
constexpr int kFractionBits = 15;
constexpr std::int64_t kUnits = 1 << kFractionBits;

std::int64_t in_units(double pixels) { return std::llround(pixels * static_cast<double>(kUnits)); }

void place_sample(double u, double v, PanoramaSize size, size_t i, SamplePositions positions) {
  const std::int64_t column = in_units(u);
  const auto turned = static_cast<int>((column >> kFractionBits) % size.width);
  const int left = turned < 0 ? turned + size.width : turned;
  const int right = left + 1 == size.width ? 0 : left + 1;
  // Above the centre of the first row and below that of the last one, the row itself is used.
  const std::int64_t row = in_units(std::clamp(v, 0.0, size.height - 1.0));
  const int upper = std::min(static_cast<int>(row >> kFractionBits), size.height - 2);
  const std::int64_t below = std::min(row - upper * kUnits, kUnits - 1);
  positions.offset_left[i] = (left * size.height + upper) * 3;
  positions.offset_right[i] = (right * size.height + upper) * 3;
  positions.weight_right[i] = twice_weight(static_cast<int>(column & (kUnits - 1)));
  positions.weight_lower[i] = twice_weight(static_cast<int>(below));
}

}  // namespace

PrecisePositions::PrecisePositions(int rows)
    : sin_phi_(static_cast<size_t>(rows)), cos_phi_(static_cast<size_t>(rows)) {
  fill_latitudes<double>(rows, sin_phi_, cos_phi_);
}

PixelPosition PrecisePositions::seen_at(int row, double omega, const PreciseOffset& offset,
                                        PanoramaSize captured) const {
  const auto i = static_cast<size_t>(row);
  const double forward = cos_phi_[i] + omega * offset.forward;
  const double up = sin_phi_[i] + omega * offset.up;
  const double side = omega * offset.side;
  const double plan = std::sqrt(forward * forward + side * side);
  // atan2(0, 0) is 0 or pi depending on the signs of the zeros; a point at the station is taken to
  // be ahead.
  const double turn = plan > 0.0 ? std::atan2(side, forward) : 0.0;
  return {turn * captured.width / kTwoPi,
          (kHalfPi - std::atan2(up, plan)) * captured.height / kPi - 0.5};
}

void PrecisePositions::find(int first_row, std::span<const float> omega,
                            const Eigen::Vector3d& displacement_m, double theta_rad,
                            PanoramaSize captured, SamplePositions positions) const {
  const PreciseOffset offset = precise_offset(displacement_m, theta_rad);
  const double ahead_u = pixel_from_angles({theta_rad, 0.0}, captured).u;
  for (size_t i = 0; i < omega.size(); ++i) {
    const PixelPosition at = seen_at(first_row + static_cast<int>(i), omega[i], offset, captured);
    place_sample(ahead_u + at.u, at.v, captured, i, positions);
  }
}

}  // namespace raywalk
