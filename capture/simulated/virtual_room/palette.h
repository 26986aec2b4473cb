// Colours and surfaces as a seed picks them.
#pragma once

#include "capture/simulated/virtual_room/hash_random.h"
#include "capture/simulated/virtual_room/surface.h"

namespace raywalk {

// A colour of hue 0..1 (red, green, blue at thirds), saturation and brightness 0..1.
Color color_from_hue(double hue, double saturation, double value);

// Wood from pale birch to dark walnut.
Surface random_wood(HashRandom* random);
// Bright, saturated paint with the faint grain of what it covers.
Surface random_lacquer(HashRandom* random);
Surface random_fabric(HashRandom* random);
// Painted plaster, light, in some tint.
Surface random_plaster(HashRandom* random);

}  // namespace raywalk
