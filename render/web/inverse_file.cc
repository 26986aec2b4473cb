#include "render/web/inverse_file.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>

namespace raywalk::render {
namespace {

std::uint16_t value_of(float inverse, double step_per_m) {
  return static_cast<std::uint16_t>(
      std::lround(std::clamp(inverse / step_per_m, 0.0, double{kLargestInverseValue})));
}

std::vector<std::byte> deflated(const std::vector<std::uint8_t>& bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::byte> stream(size);
  const int result = compress2(reinterpret_cast<Bytef*>(stream.data()), &size, bytes.data(),
                               bytes.size(), Z_DEFAULT_COMPRESSION);
  if (result != Z_OK) throw std::bad_alloc();  // compressBound() excludes any other reason
  stream.resize(size);
  return stream;
}

}  // namespace

std::vector<std::byte> encode_inverse(const InverseMap& map, double step_per_m) {
  const PanoramaSize size = map.size();
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  std::vector<std::uint8_t> bytes(2 * pixels);
  for (int theta = 0; theta < size.width; ++theta) {
    std::uint16_t above = 0;
    for (int row = 0; row < size.height; ++row) {
      const std::uint16_t value = value_of(map.at(theta, row), step_per_m);
      const auto difference = static_cast<std::uint16_t>(value - above);
      const auto i = static_cast<std::size_t>(row) * static_cast<std::size_t>(size.width) +
                     static_cast<std::size_t>(theta);
      bytes[i] = static_cast<std::uint8_t>(difference & 0xFF);
      bytes[pixels + i] = static_cast<std::uint8_t>(difference >> 8);
      above = value;
    }
  }
  return deflated(bytes);
}

}  // namespace raywalk::render
