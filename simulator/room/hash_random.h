// Random numbers that are a pure function of a key, independent of platform and number of threads.
// (The distributions of <random> are implementation-defined.)
#pragma once

#include <cmath>
#include <cstdint>

#include "core/geometry/sphere.h"

namespace raywalk::simulator {

// A hash of all 64 bits: the output function of SplitMix64 (Steele, Lea, Flood 2014, "Fast
// splittable pseudorandom number generators").
constexpr std::uint64_t hash_bits(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

// Hash of an ordered pair.
constexpr std::uint64_t hash_bits(std::uint64_t a, std::uint64_t b) {
  return hash_bits(hash_bits(a) ^ b);
}

// Uniform in [0, 1), from the upper 53 bits, the precision of a double.
constexpr double uniform_from_bits(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

// Two independent normal deviates of mean 0 and standard deviation 1 (Box and Muller 1958).
struct NormalPair {
  double first = 0.0;
  double second = 0.0;
};
inline NormalPair normal_pair(std::uint64_t key) {
  // 1 - u is in (0, 1], where the logarithm is finite.
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform_from_bits(hash_bits(key, 0))));
  const double angle = kTwoPi * uniform_from_bits(hash_bits(key, 1));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

// A sequence of random numbers.
class HashRandom {
 public:
  explicit HashRandom(std::uint64_t key) : key_(hash_bits(key)) {}

  // An independent sequence, unaffected by draws from this one.
  HashRandom branch(std::uint64_t number) const { return HashRandom(hash_bits(key_, ~number)); }

  std::uint64_t bits() { return hash_bits(key_, count_++); }
  double uniform() { return uniform_from_bits(bits()); }
  double uniform(double min, double max) { return min + (max - min) * uniform(); }
  // Uniform integer in [0, count); count >= 1.
  int below(int count) { return static_cast<int>(uniform() * count); }
  bool chance(double probability) { return uniform() < probability; }
  double normal() { return normal_pair(bits()).first; }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

}  // namespace raywalk::simulator
