#include "simulator/room/hash_random.h"

#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk::capture {

NormalPair normal_pair(std::uint64_t key) {
  // 1 - u is in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform_from_bits(hash_bits(key, 0))));
  const double angle = kTwoPi * uniform_from_bits(hash_bits(key, 1));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace raywalk::capture
