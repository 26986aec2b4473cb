// For tests: reads the distances of an export as the page does.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/room/distance_maps.h"

namespace raywalk::render {

// Throws std::runtime_error unless the stream holds exactly a map of that width.
inline InverseMap decoded_inverse(std::span<const std::byte> stream, int width, double step_per_m) {
  InverseMap map({width, width / 2});
  const std::size_t pixels = map.values().size();
  std::vector<std::uint8_t> bytes(2 * pixels + 1);
  uLongf size = bytes.size();
  const int result =
      uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(stream.data()), stream.size());
  if (result != Z_OK || size != 2 * pixels) throw std::runtime_error("not a map of this width");
  for (int theta = 0; theta < width; ++theta) {
    std::uint16_t value = 0;
    for (int row = 0; row < width / 2; ++row) {
      const auto i = static_cast<std::size_t>(row * width + theta);
      value = static_cast<std::uint16_t>(value + bytes[i] + (bytes[pixels + i] << 8));
      map.at(theta, row) = static_cast<float>(value * step_per_m);
    }
  }
  return map;
}

}  // namespace raywalk::render
