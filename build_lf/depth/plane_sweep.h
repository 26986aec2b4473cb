// The plane sweep: matching costs for a set of assumed distances.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "build_lf/depth/tile_views.h"

namespace raywalk::build_lf {

// Layers are spheres around the reference, equally spaced in inverse distance starting at 0
// (infinity), so that neighbouring layers differ by the same parallax.
struct SweepLayers {
  int count = 0;
  double step_per_m = 0.0;  // inverse distance of layer k is k * step_per_m

  double last_per_m() const { return step_per_m * (count - 1); }
};

// Layers from 0 to `max_per_m`, 1/m, at most 1.5 pixels of parallax apart at the longest baseline
// `reach_m`; finer layers do not improve views, as the parabola fit and
// the planes of surface_choice.h interpolate. The count is a multiple of 16, at least 16.
SweepLayers sweep_layers(double max_per_m, double reach_m, PanoramaSize size);

struct CostVolume {
  PanoramaSize size;
  SweepLayers layers;
  std::pmr::vector<std::uint8_t> cost;  // [theta][phi][layer], 0 (equal) to 176
  std::vector<std::uint8_t> luminance;  // [theta][phi] of the reference
  std::vector<std::uint8_t> valid;      // [theta][phi]: 1 where there is something to compare
};

// Sweeps one reference. `volume` is overwritten; its memory is reused. The cost of a layer is
// mostly the mean difference over the better half of the stations, which makes it robust to
// occlusion (kShareOfAllViews).
void sweep(const TileViews& views, const SweepLayers& layers, CostVolume* volume);

}  // namespace raywalk::build_lf
