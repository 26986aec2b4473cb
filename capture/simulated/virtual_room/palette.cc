#include "capture/simulated/virtual_room/palette.h"

#include <algorithm>
#include <cmath>

namespace raywalk {

Color color_from_hue(double hue, double saturation, double value) {
  // Each channel is a trapezoid over the circle of hues, a third of a turn apart.
  const auto channel = [&](double shift) {
    const double turn = 6.0 * (hue + shift - std::floor(hue + shift));
    const double ramp = std::clamp(std::abs(turn - 3.0) - 1.0, 0.0, 1.0);
    return static_cast<float>(value * (1.0 - saturation * (1.0 - ramp)));
  };
  return {channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)};
}

Surface random_wood(HashRandom* random) {
  Surface wood;
  wood.pattern = Pattern::kWood;
  const double value = random->uniform(0.22, 0.62);
  wood.base = color_from_hue(random->uniform(0.055, 0.095), random->uniform(0.5, 0.75), value);
  wood.accent = static_cast<float>(random->uniform(0.3, 0.5)) * wood.base;
  wood.seed = static_cast<std::uint32_t>(random->bits());
  return wood;
}

Surface random_lacquer(HashRandom* random) {
  Surface lacquer;
  lacquer.pattern = Pattern::kWood;
  lacquer.base =
      color_from_hue(random->uniform(), random->uniform(0.15, 0.6), random->uniform(0.15, 0.6));
  lacquer.accent = 0.7F * lacquer.base;
  lacquer.seed = static_cast<std::uint32_t>(random->bits());
  return lacquer;
}

Surface random_fabric(HashRandom* random) {
  Surface fabric;
  fabric.pattern = Pattern::kFabric;
  const double hue = random->uniform();
  fabric.base = color_from_hue(hue, random->uniform(0.15, 0.5), random->uniform(0.1, 0.45));
  fabric.accent = color_from_hue(hue + random->uniform(0.05, 0.5), random->uniform(0.1, 0.5),
                                 random->uniform(0.05, 0.55));
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
  plaster.accent = color_from_hue(hue + random->uniform(-0.06, 0.06), saturation + 0.08,
                                  value * random->uniform(0.75, 0.92));
  plaster.seed = static_cast<std::uint32_t>(random->bits());
  return plaster;
}

}  // namespace raywalk
