// The limit angle k of the hybrid connection that minimises the errors of a cell's views: equations
// (6), (7) and (10) of the paper, built on error_model.h; Fig. 11 plots these errors.
#pragma once

#include <array>
#include <span>

namespace raywalk {

// The sampling of the sums (7) and (10); latitude rows are one degree apart.
struct CellSampling {
  double side_m = 1.0;   // N, > 0
  double step_m = 0.01;  // between stations, >= 0; the paper does not print the one it used
  int viewpoints = 49;   // per side: centres of viewpoints x viewpoints sub-cells, >= 1
};

// The errors at every whole degree of k.
struct ConnectionErrorCurve {
  static constexpr int kMinDeg = 45;  // LFU
  static constexpr int kMaxDeg = 90;  // Ray-space360
  using Values = std::array<double, kMaxDeg - kMinDeg + 1>;

  Values mismatch_rad{};        // E_m (7), falls to 0 at 90 degrees
  Values bending_rad{};         // E_b (10), grows with k
  Values total{};               // E_t (6), in [0, 2]
  int optimum_k_deg = kMaxDeg;  // of the least E_t; ties: the largest, as it connects physically
};

// The errors of a cell whose sources are at `d_src_m`. With several distances E_m and E_b are
// summed over them before (6). The maxima in (6) are those over k = 45..90 degrees at the same
// distances, so E_m / max(E_m) is 1 at 45 and E_b / max(E_b) is 1 at 90; an error that is 0 at
// every k contributes 0. Takes about 0.1 s per distance at 49 viewpoints. Throws Error for a
// sampling or distance outside its domain, or if there is no distance.
ConnectionErrorCurve connection_error_curve(const CellSampling& sampling,
                                            std::span<const double> d_src_m);

}  // namespace raywalk
