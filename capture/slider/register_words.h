// Conversion between quantities of a motion and words of a drive's registers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "capture/slider/register_map.h"
#include "capture/slider/slider.h"

namespace raywalk::capture {

// The nearest whole step. Throws UsageError if it does not fit 32 signed bits.
std::int32_t steps_from_mm(const RegisterMap& map, double mm);
double mm_from_steps(const RegisterMap& map, std::int32_t steps);

// A signed 32-bit number of two words; `first` has the lower address.
std::int32_t steps_from_words(const RegisterMap& map, std::uint16_t first, std::uint16_t second);

// The words of a move, in order. Throws UsageError, naming the value, if the position, the speed or
// the acceleration does not fit the map's words, or if speed or acceleration would be 0. Values are
// never clamped: a carriage at another speed than requested would be a wrong result.
std::vector<std::uint16_t> words_of_move(const RegisterMap& map, SafePosition target,
                                         const MotionProfile& profile);

// The words of a write of constants: start, home, stop, reset.
std::vector<std::uint16_t> fixed_words(const RegisterWrite& write);

// A flag of the status word; none if the map does not define it.
std::optional<bool> flag_of(std::uint16_t status, const std::optional<StatusBit>& bit);

}  // namespace raywalk::capture
