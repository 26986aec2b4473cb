// Colours and surfaces as a seed picks them.
#pragma once

#include "capture/simulated/virtual_room/hash_random.h"
#include "capture/simulated/virtual_room/surface.h"

namespace raywalk::capture {

// A colour of hue 0..1 (red, green, blue at thirds), saturation and brightness 0..1.
Color color_from_hue(double hue, double saturation, double value);

// From min to less than max.
struct Range {
  double min = 0.0;
  double max = 1.0;
};

// A colour drawn from ranges of hue, saturation and brightness: brightness is drawn first, then
// saturation, then hue. The second draws the former two for a hue that is given.
Color random_color(Range hue, Range saturation, Range value, HashRandom* random);
Color random_shade(double hue, Range saturation, Range value, HashRandom* random);

// Wood from pale birch to dark walnut.
Surface random_wood(HashRandom* random);
// Bright, saturated paint with the faint grain of what it covers.
Surface random_lacquer(HashRandom* random);
Surface random_fabric(HashRandom* random);
// Painted plaster, light, in some tint.
Surface random_plaster(HashRandom* random);

}  // namespace raywalk::capture
