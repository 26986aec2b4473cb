// Matches two lists of times from different clocks. The clocks differ by an unknown offset and a
// small drift, and either list may have entries without a counterpart in the other.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raywalk::capture {

// An expected picture: taken within [from_s, to_s] of the first clock. Exposures of one bracket
// share their interval.
struct ShotSlot {
  double from_s = 0.0;
  double to_s = 0.0;
};

struct TimeAlignment {
  // Per slot the index of its picture, ascending; empty for an unmatched slot.
  std::vector<std::optional<std::size_t>> picture_of_slot;
  std::size_t matched = 0;
  double offset_s = 0.0;  // picture time minus slot time, at the first slot
  double drift = 0.0;     // growth of the offset per second; under 1e-4 for a good quartz clock
  double rms_s = 0.0;     // of the residuals after offset and drift

  std::size_t unmatched(std::size_t pictures) const {  // slots plus pictures without counterpart
    return picture_of_slot.size() + pictures - 2 * matched;
  }
};

// The best alignment, and another that fits about as well, if there is one.
struct AlignmentResult {
  TimeAlignment best;
  std::optional<TimeAlignment> rival;  // set: the match is ambiguous, trust neither
};

// `slots` and `pictures_s` are in ascending order, in seconds since any epoch of the respective
// clock. `resolution_s` (> 0) is the step of the pictures' clock.
//
// Offsets are proposed by voting: every pair (slot, picture) votes for its difference. For each
// proposal, slots take the nearest picture in order, and offset and drift are fitted to these in
// turn. Proposals that lead to different assignments compete. An assignment with n unmatched rules
// out another that leaves at least n + min(n/2, 2) + 2 unmatched and does not fit clearly better,
// and one that leaves n or more unmatched with twice the residual. If the first or last picture of
// an evenly timed sequence is missing, two assignments fit equally well and `rival` is set.
AlignmentResult align_times(std::span<const ShotSlot> slots, std::span<const double> pictures_s,
                            double resolution_s);

}  // namespace raywalk::capture
