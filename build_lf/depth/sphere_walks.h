// Walks along which semi-global matching carries costs over a panorama.
#pragma once

#include <algorithm>
#include <functional>

#include "core/base/parallel.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

// A walk over the sphere's pixels by constant steps; over a pole it continues in the opposite
// column.
struct Walk {
  int theta = 0, phi = 0;
  int step_theta = 0, step_phi = 0;

  void advance(PanoramaSize size) {
    theta += step_theta;
    phi += step_phi;
    if (phi < 0 || phi >= size.height) {
      phi = phi < 0 ? 0 : size.height - 1;
      theta += size.width / 2;
      step_phi = -step_phi;
    }
    theta = (theta + size.width) % size.width;
  }
};

// How many walks cross each pixel.
inline constexpr int kPaths = 8;

// Calls body(walk, run_up, steps) for walks in eight directions: the walk first takes `run_up`
// pixels whose results do not count, then `steps` pixels. The walks of one direction visit every
// pixel once, so they run in parallel.
inline void for_each_walk(PanoramaSize size, const std::function<void(Walk, int, int)>& body) {
  const auto [width, height] = size;
  const int run_up = width / 16;
  const auto for_each = [](int count, const auto& each) {
    parallel_for(0, count, 16, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) each(i);
    });
  };
  for (const int step : {1, -1}) {
    const int first = step > 0 ? 0 : width - 1;
    for_each(height, [&, w = width](int phi) {
      body({(first - step * run_up + w) % w, phi, step, 0}, run_up, w);
    });
    // Down one column and up the opposite one, starting shortly before the zenith.
    for_each(width / 2, [&, w = width, h = height](int theta) {
      // In the smallest maps too, the walk begins at a pixel.
      const int before = std::clamp(run_up, 1, h);
      body({step > 0 ? theta + w / 2 : theta, before - 1, 0, -1}, before, 2 * h);
    });
    for (const int aside : {1, -1}) {
      for_each(width, [&, h = height](int theta) {
        body({theta, step > 0 ? 0 : h - 1, aside, step}, 0, h);
      });
    }
  }
}

}  // namespace raywalk::build_lf
