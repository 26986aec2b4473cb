// Random colours and surfaces.
#pragma once

#include "simulator/room/hash_random.h"
#include "simulator/room/surface.h"

namespace raywalk::capture {

// HSV to RGB: hue 0..1 (red 0, green 1/3, blue 2/3), saturation and value 0..1.
Color color_from_hue(double hue, double saturation, double value);

// The half-open range [min, max).
struct Range {
  double min = 0.0;
  double max = 1.0;
};

// A random colour from ranges of hue, saturation and value, drawn in the order value, saturation,
// hue. random_shade has a fixed hue.
Color random_color(Range hue, Range saturation, Range value, HashRandom* random);
Color random_shade(double hue, Range saturation, Range value, HashRandom* random);

// Wood from pale birch to dark walnut.
Surface random_wood(HashRandom* random);
// Bright, saturated paint with a faint grain.
Surface random_lacquer(HashRandom* random);
Surface random_fabric(HashRandom* random);
// Light, tinted plaster.
Surface random_plaster(HashRandom* random);

}  // namespace raywalk::capture
