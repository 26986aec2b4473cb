// Quantities of a motion as the words of a drive's registers, and back.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "capture/slider/register_map.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// The nearest whole step. Throws UsageError where that does not fit a signed 32-bit word pair.
std::int32_t steps_from_mm(const RegisterMap& map, double mm);
double mm_from_steps(const RegisterMap& map, std::int32_t steps);

// A signed 32-bit number of two words, the first of lower address.
std::int32_t steps_from_words(const RegisterMap& map, std::uint16_t first, std::uint16_t second);

// The words of a move, in order. Throws UsageError, naming the value, where the position, the speed
// or the acceleration does not fit the map's words, or would be 0 (never the nearest value that
// fits: a carriage at another speed than asked for is a wrong result).
std::vector<std::uint16_t> words_of_move(const RegisterMap& map, SafePosition target,
                                         const MotionProfile& profile);

// The words of a write that holds numbers only: start, home, stop, reset.
std::vector<std::uint16_t> fixed_words(const RegisterWrite& write);

// What the status word says of a flag; none for one that the map does not have.
std::optional<bool> flag_of(std::uint16_t status, const std::optional<StatusBit>& bit);

}  // namespace raywalk::capture
