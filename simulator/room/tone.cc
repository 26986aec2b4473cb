#include "simulator/room/tone.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/panorama/srgb.h"

namespace raywalk::capture {
namespace {

constexpr double kKnee = 0.8;
constexpr double kBrightest = 16.0;  // above it every level rounds to 255
constexpr int kTableSize = 4096;

double soft_highlight(double light) {
  if (light <= kKnee) return light;
  const double room = 1.0 - kKnee;
  return kKnee + room * (1.0 - std::exp((kKnee - light) / room));
}

// Lookup table over the square root of light, which is nearly perceptually uniform and so needs few
// entries.
std::array<float, kTableSize + 1> make_table(Highlights highlights) {
  std::array<float, kTableSize + 1> table{};
  for (int i = 0; i <= kTableSize; ++i) {
    const double root = std::sqrt(kBrightest) * i / kTableSize;
    table[static_cast<std::size_t>(i)] = static_cast<float>(
        srgb_level_from_linear(highlights == Highlights::kSoft ? soft_highlight(root * root)
                                                               : std::min(root * root, 1.0)));
  }
  return table;
}

}  // namespace

float level_from_light(float light, Highlights highlights) {
  static const std::array<float, kTableSize + 1> soft = make_table(Highlights::kSoft);
  static const std::array<float, kTableSize + 1> clipped = make_table(Highlights::kClipped);
  const auto& table = highlights == Highlights::kSoft ? soft : clipped;
  const float root = std::sqrt(std::clamp(light, 0.0F, static_cast<float>(kBrightest))) *
                     (static_cast<float>(kTableSize) / std::sqrt(static_cast<float>(kBrightest)));
  const int index = std::min(static_cast<int>(root), kTableSize - 1);
  const auto entry = static_cast<std::size_t>(index);
  return table[entry] + (root - static_cast<float>(index)) * (table[entry + 1] - table[entry]);
}

}  // namespace raywalk::capture
