// For tests: every pixel of a panorama.
#pragma once

#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

struct PixelPlace {
  int u = 0, v = 0;
};

// Column by column.
inline std::vector<PixelPlace> pixels_of(PanoramaSize size) {
  std::vector<PixelPlace> pixels;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) pixels.push_back({u, v});
  }
  return pixels;
}

}  // namespace raywalk
