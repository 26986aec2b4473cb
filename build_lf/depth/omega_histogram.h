// How much of the sphere shows surfaces at which inverse distance, over many maps.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {

// Inverse distances from 0 to a limit by solid angle. The weights are whole numbers, so that the
// sum of the histograms of parts is that of the whole, in any order.
class OmegaHistogram {
 public:
  explicit OmegaHistogram(double limit_per_m) : limit_per_m_(limit_per_m), share_(kBins) {}
  // Of what bytes() gave. Throws Error for other bytes.
  OmegaHistogram(double limit_per_m, std::string_view bytes);

  // Counts the confident pixels of a map.
  void add(const InverseDistanceMap& map);
  // Adds another one of the same limit.
  void add(const OmegaHistogram& other);
  // The largest inverse distance of the bin above which less than `share` of the solid angle lies.
  double exceeded_by(double share) const;
  bool empty() const { return total_ == 0; }
  std::string bytes() const;

 private:
  static constexpr int kBins = 1024;
  double limit_per_m_;
  std::vector<std::int64_t> share_;
  std::int64_t total_ = 0;
};

}  // namespace raywalk::build_lf
