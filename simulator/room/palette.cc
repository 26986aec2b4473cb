#include "simulator/room/palette.h"

#include <algorithm>
#include <cmath>

namespace raywalk::capture {

Color color_from_hue(double hue, double saturation, double value) {
  // Each channel is a trapezoid over the circle of hues, a third of a turn apart.
  const auto channel = [&](double shift) {
    const double turn = 6.0 * (hue + shift - std::floor(hue + shift));
    const double ramp = std::clamp(std::abs(turn - 3.0) - 1.0, 0.0, 1.0);
    return static_cast<float>(value * (1.0 - saturation * (1.0 - ramp)));
  };
  return {channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)};
}

Color random_color(Range hue, Range saturation, Range value, HashRandom* random) {
  const double drawn_value = random->uniform(value.min, value.max);
  const double drawn_saturation = random->uniform(saturation.min, saturation.max);
  return color_from_hue(random->uniform(hue.min, hue.max), drawn_saturation, drawn_value);
}

Color random_shade(double hue, Range saturation, Range value, HashRandom* random) {
  const double drawn_value = random->uniform(value.min, value.max);
  return color_from_hue(hue, random->uniform(saturation.min, saturation.max), drawn_value);
}

Surface random_wood(HashRandom* random) {
  Surface wood;
  wood.pattern = Pattern::kWood;
  wood.base = random_color({0.055, 0.095}, {0.5, 0.75}, {0.22, 0.62}, random);
  wood.accent = static_cast<float>(random->uniform(0.3, 0.5)) * wood.base;
  wood.seed = static_cast<std::uint32_t>(random->bits());
  return wood;
}

Surface random_lacquer(HashRandom* random) {
  Surface lacquer;
  lacquer.pattern = Pattern::kWood;
  lacquer.base = random_color({0.0, 1.0}, {0.15, 0.6}, {0.15, 0.6}, random);
  lacquer.accent = 0.7F * lacquer.base;
  lacquer.seed = static_cast<std::uint32_t>(random->bits());
  return lacquer;
}

Surface random_fabric(HashRandom* random) {
  Surface fabric;
  fabric.pattern = Pattern::kFabric;
  const double hue = random->uniform();
  fabric.base = random_shade(hue, {0.15, 0.5}, {0.1, 0.45}, random);
  const double accent_value = random->uniform(0.05, 0.55);
  const double accent_saturation = random->uniform(0.1, 0.5);
  fabric.accent = color_from_hue(hue + random->uniform(0.05, 0.5), accent_saturation, accent_value);
  fabric.period = static_cast<float>(random->uniform(0.06, 0.14));
  fabric.seed = static_cast<std::uint32_t>(random->bits());
  return fabric;
}

Surface random_plaster(HashRandom* random) {
  Surface plaster;
  plaster.pattern = Pattern::kPlaster;
  const double hue = random->uniform(), saturation = random->uniform(0.04, 0.25);
  const double value = random->uniform(0.42, 0.66);
  plaster.base = color_from_hue(hue, saturation, value);
  const double accent_value = value * random->uniform(0.75, 0.92);
  plaster.accent =
      color_from_hue(hue + random->uniform(-0.06, 0.06), saturation + 0.08, accent_value);
  plaster.seed = static_cast<std::uint32_t>(random->bits());
  return plaster;
}

}  // namespace raywalk::capture
