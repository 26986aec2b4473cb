#include "build_lf/depth/omega_histogram.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/files/packed_values.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {
namespace {

// A pixel at the horizon; small enough for 10^11 pixels.
constexpr double kFullWeight = 1 << 24;

}  // namespace

OmegaHistogram::OmegaHistogram(double limit_per_m, std::string_view bytes)
    : limit_per_m_(limit_per_m) {
  PackedReader reader(bytes);
  share_ = reader.next_all<std::int64_t>();
  if (share_.size() != kBins) throw Error("a histogram of distances is damaged");
  for (const std::int64_t share : share_) total_ += share;
}

void OmegaHistogram::add(const InverseDistanceMap& map) {
  constexpr int kConfident = 64;
  const auto rows = static_cast<size_t>(map.size.height);
  std::vector<std::int64_t> weights(rows);
  for (size_t row = 0; row < rows; ++row) {
    const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, map.size).phi_rad;
    weights[row] = std::llround(kFullWeight * std::cos(phi_rad));
  }
  for (size_t p = 0; p < map.omega.size(); ++p) {
    if (map.confidence[p] < kConfident) continue;
    const double bin = std::clamp(map.omega[p] / limit_per_m_ * kBins, 0.0, kBins - 1.0);
    share_[static_cast<size_t>(bin)] += weights[p % rows];
    total_ += weights[p % rows];
  }
}

void OmegaHistogram::add(const OmegaHistogram& other) {
  for (size_t bin = 0; bin < share_.size(); ++bin) share_[bin] += other.share_[bin];
  total_ += other.total_;
}

double OmegaHistogram::exceeded_by(double share) const {
  int bin = kBins - 1;
  for (std::int64_t nearer = 0; bin > 0; --bin) {
    nearer += share_[static_cast<size_t>(bin)];
    if (static_cast<double>(nearer) > share * static_cast<double>(total_)) break;
  }
  return limit_per_m_ * (bin + 1) / kBins;
}

std::string OmegaHistogram::bytes() const {
  PackedWriter writer;
  writer.add_all(share_);
  return writer.bytes();
}

}  // namespace raywalk::build_lf
