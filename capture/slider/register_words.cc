#include "capture/slider/register_words.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "capture/base/units.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr double kLargest16 = 0xffff;
constexpr double kLargest32 = 0xffffffff;

std::uint16_t high_word(std::uint32_t value) { return static_cast<std::uint16_t>(value >> 16); }
std::uint16_t low_word(std::uint32_t value) { return static_cast<std::uint16_t>(value & 0xffff); }

std::uint32_t whole_units(const RegisterMap& map, const char* what, double asked, double units,
                          double largest) {
  const double rounded = std::round(units);
  if (!(rounded >= 1.0 && rounded <= largest)) {
    throw UsageError(fmt::format(
        "register map '{}': {} {:g} would be {:g} in its register, which holds 1 to {:.0f}; choose "
        "another value, or correct the map's scale",
        map.name, what, asked, units, largest));
  }
  return static_cast<std::uint32_t>(rounded);
}

std::uint32_t speed_units(const RegisterMap& map, double speed_mm_s, double largest) {
  return whole_units(map, "speed in mm/s", speed_mm_s, speed_mm_s * map.speed_per_mm_s, largest);
}

// Either units of acceleration, or the milliseconds t in which it reaches the map's speed v: from
// v = a t, t = 1000 v / a.
std::uint32_t acceleration_units(const RegisterMap& map, double acceleration_mm_s2) {
  const double units = map.acceleration_time_to_mm_s > 0.0
                           ? kMsPerSecond * map.acceleration_time_to_mm_s / acceleration_mm_s2
                           : map.acceleration_per_mm_s2 * acceleration_mm_s2;
  return whole_units(map, "acceleration in mm/s^2", acceleration_mm_s2, units, kLargest16);
}

}  // namespace

std::int32_t steps_from_mm(const RegisterMap& map, double mm) {
  const double steps = std::round(mm * map.steps_per_mm);
  if (!(steps >= std::numeric_limits<std::int32_t>::min() &&
        steps <= std::numeric_limits<std::int32_t>::max())) {
    throw UsageError(fmt::format(
        "register map '{}': {:.3f} mm are {:.0f} steps, more than 32 bits hold; correct "
        "steps_per_mm",
        map.name, mm, steps));
  }
  return static_cast<std::int32_t>(steps);
}

double mm_from_steps(const RegisterMap& map, std::int32_t steps) {
  return static_cast<double>(steps) / map.steps_per_mm;
}

std::int32_t steps_from_words(const RegisterMap& map, std::uint16_t first, std::uint16_t second) {
  const std::uint32_t high = map.low_word_first ? second : first;
  const std::uint32_t low = map.low_word_first ? first : second;
  return static_cast<std::int32_t>(high << 16 | low);  // two's complement, as C++20 defines it
}

std::vector<std::uint16_t> words_of_move(const RegisterMap& map, SafePosition target,
                                         const MotionProfile& profile) {
  const auto position = static_cast<std::uint32_t>(steps_from_mm(map, target.mm()));
  std::vector<std::uint16_t> words;
  for (const BlockWord& word : map.move.words) {
    switch (word.meaning) {
      case WordMeaning::kConstant:
        words.push_back(word.constant);
        break;
      case WordMeaning::kPositionHigh:
        words.push_back(high_word(position));
        break;
      case WordMeaning::kPositionLow:
        words.push_back(low_word(position));
        break;
      case WordMeaning::kSpeed:
        words.push_back(low_word(speed_units(map, profile.speed_mm_s, kLargest16)));
        break;
      case WordMeaning::kSpeedHigh:
        words.push_back(high_word(speed_units(map, profile.speed_mm_s, kLargest32)));
        break;
      case WordMeaning::kSpeedLow:
        words.push_back(low_word(speed_units(map, profile.speed_mm_s, kLargest32)));
        break;
      case WordMeaning::kAcceleration:
      case WordMeaning::kDeceleration:
        words.push_back(low_word(acceleration_units(map, profile.acceleration_mm_s2)));
        break;
    }
  }
  return words;
}

std::vector<std::uint16_t> fixed_words(const RegisterWrite& write) {
  std::vector<std::uint16_t> words;
  for (const BlockWord& word : write.words) words.push_back(word.constant);
  return words;
}

std::optional<bool> flag_of(std::uint16_t status, const std::optional<StatusBit>& bit) {
  if (!bit) return std::nullopt;
  return ((status >> bit->bit & 1) != 0) != bit->active_low;
}

}  // namespace raywalk::capture
