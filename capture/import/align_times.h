// Which of two lists of times belong together, where the clocks that gave them differ by an unknown
// offset and run at slightly different rates, and either list may have what the other lacks.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk::capture {

// A picture that was asked for: taken within [from_s, to_s] of the first clock. Exposures of one
// bracket share their interval.
struct ShotSlot {
  double from_s = 0.0;
  double to_s = 0.0;
};

struct TimeAlignment {
  // Per slot the index of its picture, ascending; none where it lacks one.
  std::vector<std::optional<std::size_t>> picture_of_slot;
  std::size_t matched = 0;
  double offset_s = 0.0;  // picture time minus slot time, at the first slot
  double drift = 0.0;     // by how much the offset grows per second; a good quartz has under 1e-4
  double rms_s = 0.0;     // of what offset and drift leave over

  std::size_t unmatched(std::size_t pictures) const {  // slots without, and pictures too many
    return picture_of_slot.size() + pictures - 2 * matched;
  }
};

// The best alignment, and one that the times cannot tell from it.
struct AlignmentResult {
  TimeAlignment best;
  std::optional<TimeAlignment> rival;  // there is one: neither can be trusted
};

// Slots and pictures in ascending order, `resolution_s` (> 0) the steps of the pictures' clock.
// Everything in seconds since any moment of the respective clock.
//
// For a given offset and drift the assignment that keeps both orders, matches the most slots and
// among those has the least squared residuals is found by dynamic programming. Offsets are proposed
// by votes: every pair (slot, picture) votes for its difference. Proposals that end in different
// assignments compete: beside one that leaves n unmatched, another is refuted that leaves at least
// n + min(n/2, 2) + 2 and does not fit clearly better, or no fewer and fits twice as badly. A
// last picture dropped from an evenly timed sequence leaves two equal ones, and the result says so.
AlignmentResult align_times(std::span<const ShotSlot> slots, std::span<const double> pictures_s,
                            double resolution_s);

}  // namespace raywalk::capture
