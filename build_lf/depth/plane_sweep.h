// The plane sweep: how well each assumed distance explains what the other stations see.
#pragma once

#include <cstdint>
#include <vector>

#include "build_lf/depth/tile_views.h"

namespace raywalk::build_lf {

// Layers are spheres around the reference, equally spaced in inverse distance from 0 (infinitely
// far) on, so that neighbouring layers differ by the same parallax everywhere.
struct SweepLayers {
  int count = 0;
  double step_per_m = 0.0;  // inverse distance of layer k is k * step_per_m

  double last_per_m() const { return step_per_m * (count - 1); }
};

// Layers from 0 to at least `max_per_m`, at most one and a half pixels of parallax apart at the
// longest baseline `reach_m`: the parabola through the best layer and refine_parallax interpolate,
// and closer layers render no better. At least 16 layers, a multiple of 16.
SweepLayers sweep_layers(double max_per_m, double reach_m, PanoramaSize size);

struct CostVolume {
  PanoramaSize size;
  SweepLayers layers;
  std::vector<std::uint8_t> cost;       // [theta][phi][layer], 0 (alike) to 176
  std::vector<std::uint8_t> luminance;  // [theta][phi] of the reference
  std::vector<std::uint8_t> valid;      // [theta][phi]: 1 where something could be compared
};

// Sweeps one reference. `volume` is overwritten; its memory is kept from one call to the next. The
// cost of a layer is the mean difference over the better half of the stations: what the others
// cannot see, behind an edge or between thin things, does not count against a distance.
void sweep(const TileViews& views, const SweepLayers& layers, CostVolume* volume);

}  // namespace raywalk::build_lf
