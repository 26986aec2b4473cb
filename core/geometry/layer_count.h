// The number of depth layers a view needs.
//
// HLF-VD can correct in N layers, equally spaced in inverse distance. The inverse distance of a
// pixel is then off by at most half a layer, and phi* by at most half a layer times |d alpha / d
// omega|, where alpha = phi* + asin(q), q = d_p omega sin phi* (law of sines), omega = 1 / d_src:
//
//   d alpha / d omega = d_p sin phi* / sqrt(1 - q^2) <= d_p / sqrt(1 - q^2).
//
// The slope is unbounded as q approaches 1 (the ray grazes the layer's circle), so the count is
// computed for q = sin 80 deg and holds for every pixel with a smaller q.
#pragma once

namespace raywalk {

// Inverse distances of a scene, 1/m; 0 is infinitely far. 0 <= min <= max.
struct OmegaRange {
  double min = 0.0;
  double max = 0.0;

  friend bool operator==(const OmegaRange&, const OmegaRange&) = default;
};

// Layers needed to keep the error of phi* within `tolerance_rad` (> 0) at the largest d_p of a
// view, metres. In [1, 65536].
int layers_for_tolerance(OmegaRange range, double largest_d_p_m, double tolerance_rad);

}  // namespace raywalk
