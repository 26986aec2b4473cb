#include "capture/import/align_times.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "core/base/median.h"

namespace raywalk::capture {
namespace {

// Largest variation of a camera's shutter lag from shot to shot.
constexpr double kLagJitter_s = 0.4;
// Two consumer quartz clocks, each off by 100 ppm, in opposite directions.
constexpr double kMostDrift = 2e-4;
constexpr std::size_t kVotingSlots = 300;  // subsampled beyond this many
constexpr std::size_t kProposals = 40;     // includes offsets wrong by a few slots
constexpr int kRefinements = 4;

double middle_of(const ShotSlot& slot) { return 0.5 * (slot.from_s + slot.to_s); }

struct Problem {
  std::span<const ShotSlot> slots;
  std::span<const double> pictures_s;
  double tolerance_s = 0.0;
  double rms_floor_s = 0.0;  // residuals below this are not compared
};

// Distance in time of a picture from the interval of a slot; 0 inside it.
double residual(const Problem& problem, const TimeAlignment& clocks, std::size_t slot,
                std::size_t picture) {
  const ShotSlot& interval = problem.slots[slot];
  const double shift_s = clocks.offset_s + clocks.drift * middle_of(interval);
  const double time_s = problem.pictures_s[picture] - shift_s;
  return std::max({interval.from_s - time_s, time_s - interval.to_s, 0.0});
}

// A picture may be off by half a step of its clock plus the camera's jitter, but not by more than
// half a pause between slots (the 5th percentile), beyond which it is nearer to another slot.
double tolerance(std::span<const ShotSlot> slots, double resolution_s) {
  std::vector<double> pauses_s;
  for (std::size_t i = 1; i < slots.size(); ++i) {
    const bool same_bracket = slots[i].from_s == slots[i - 1].from_s;
    if (!same_bracket) pauses_s.push_back(slots[i].from_s - slots[i - 1].to_s);
  }
  double short_pause_s = HUGE_VAL;
  if (!pauses_s.empty()) {
    const auto at = pauses_s.begin() + static_cast<std::ptrdiff_t>(pauses_s.size() / 20);
    std::nth_element(pauses_s.begin(), at, pauses_s.end());
    short_pause_s = *at;
  }
  return std::min(0.5 * resolution_s + kLagJitter_s,
                  std::max(0.45 * short_pause_s, 0.25 * resolution_s));
}

// Gives every slot, in order, the nearest picture within the tolerance.
void assign(const Problem& problem, TimeAlignment* alignment) {
  const std::size_t pictures = problem.pictures_s.size();
  alignment->picture_of_slot.assign(problem.slots.size(), std::nullopt);
  alignment->matched = 0;
  double squares = 0.0;
  std::size_t picture = 0;
  for (std::size_t slot = 0; slot < problem.slots.size() && picture < pictures; ++slot) {
    const ShotSlot& interval = problem.slots[slot];
    const double shift_s = alignment->offset_s + alignment->drift * middle_of(interval);
    const double earliest_s = interval.from_s + shift_s - problem.tolerance_s;
    while (picture < pictures && problem.pictures_s[picture] < earliest_s) ++picture;
    // The next picture may be nearer, unless it is the next exposure of the same bracket.
    const bool ends_bracket =
        slot + 1 == problem.slots.size() || problem.slots[slot + 1].from_s != interval.from_s;
    while (ends_bracket && picture + 1 < pictures &&
           residual(problem, *alignment, slot, picture + 1) <
               residual(problem, *alignment, slot, picture)) {
      ++picture;
    }
    if (picture == pictures) break;
    const double off_s = residual(problem, *alignment, slot, picture);
    if (off_s > problem.tolerance_s) continue;
    squares += off_s * off_s;
    ++alignment->matched;
    alignment->picture_of_slot[slot] = picture++;
  }
  alignment->rms_s = std::sqrt(squares / std::max(1.0, static_cast<double>(alignment->matched)));
}

// Fits offset and drift to the pairs by least squares. As short sessions do not determine the
// drift, it is drawn to 0 as if 1000 s of the usual scatter had been seen without any. The median
// of what remains is robust to wrongly matched pictures.
void fit_clocks(const Problem& problem, TimeAlignment* alignment) {
  std::vector<std::pair<double, double>> pairs;  // time of the slot, picture minus slot
  double mean_s = 0.0, mean_difference_s = 0.0;
  for (std::size_t slot = 0; slot < problem.slots.size(); ++slot) {
    const auto& picture = alignment->picture_of_slot[slot];
    if (!picture) continue;
    const double slot_s = middle_of(problem.slots[slot]);
    pairs.emplace_back(slot_s, problem.pictures_s[*picture] - slot_s);
    mean_s += slot_s / static_cast<double>(alignment->matched);
    mean_difference_s += pairs.back().second / static_cast<double>(alignment->matched);
  }
  constexpr double kPrior_s2 = 6000.0 * 6000.0;  // (scatter of 0.3 s / usual drift of 5e-5)^2
  double s_xx = kPrior_s2, s_xy = 0.0;
  for (const auto& [slot_s, difference_s] : pairs) {
    s_xx += (slot_s - mean_s) * (slot_s - mean_s);
    s_xy += (slot_s - mean_s) * (difference_s - mean_difference_s);
  }
  alignment->drift = std::clamp(s_xy / s_xx, -kMostDrift, kMostDrift);
  std::vector<double> offsets_s;
  offsets_s.reserve(pairs.size());
  for (const auto& [slot_s, difference_s] : pairs) {
    offsets_s.push_back(difference_s - alignment->drift * slot_s);
  }
  alignment->offset_s = median(offsets_s);
}

// The offsets that most pairs of a slot and a picture have. Bins are as wide as the tolerance; each
// is counted together with its upper neighbour, so that no cluster is split at a bin's edge.
std::vector<double> propose_offsets(const Problem& problem) {
  const std::size_t stride = (problem.slots.size() + kVotingSlots - 1) / kVotingSlots;
  std::vector<std::int64_t> votes;
  votes.reserve(kVotingSlots * problem.pictures_s.size());
  for (std::size_t slot = 0; slot < problem.slots.size(); slot += stride) {
    for (const double picture_s : problem.pictures_s) {
      const double offset_s = picture_s - middle_of(problem.slots[slot]);
      votes.push_back(static_cast<std::int64_t>(std::floor(offset_s / problem.tolerance_s)));
    }
  }
  std::sort(votes.begin(), votes.end());
  std::vector<std::pair<std::ptrdiff_t, std::int64_t>> counted;
  for (auto first = votes.begin(); first != votes.end();) {
    const auto next = std::upper_bound(first, votes.end(), *first);
    counted.emplace_back(std::upper_bound(next, votes.end(), *first + 1) - first, *first);
    first = next;
  }
  std::ranges::sort(counted, std::greater<>());
  counted.resize(std::min(counted.size(), kProposals));
  std::vector<double> offsets_s;
  offsets_s.reserve(counted.size());
  for (const auto& [count, bin] : counted) {
    offsets_s.push_back((static_cast<double>(bin) + 1.0) * problem.tolerance_s);
  }
  return offsets_s;
}

// All distinct assignments reached from the proposals, best first.
std::vector<TimeAlignment> contenders(const Problem& problem) {
  std::vector<TimeAlignment> found;
  for (const double offset_s : propose_offsets(problem)) {
    TimeAlignment alignment;
    alignment.offset_s = offset_s;
    for (int round = 0; round < kRefinements; ++round) {
      assign(problem, &alignment);
      if (alignment.matched == 0) break;
      if (round + 1 < kRefinements) fit_clocks(problem, &alignment);
    }
    const bool is_known = std::ranges::any_of(found, [&](const TimeAlignment& other) {
      return other.picture_of_slot == alignment.picture_of_slot;
    });
    if (alignment.matched > 0 && !is_known) found.push_back(std::move(alignment));
  }
  const std::size_t pictures = problem.pictures_s.size();
  std::ranges::sort(found, {}, [&](const TimeAlignment& each) {
    return std::pair(each.unmatched(pictures), each.rms_s);
  });
  return found;
}

// Whether `best` leaves no doubt about another that leaves as many unmatched, or more.
bool rules_out(const Problem& problem, const TimeAlignment& best, const TimeAlignment& other) {
  const std::size_t pictures = problem.pictures_s.size();
  const std::size_t unmatched = best.unmatched(pictures);
  const double rms_s = std::max(best.rms_s, problem.rms_floor_s);
  if (other.rms_s > 2.0 * rms_s || 2 * other.matched < best.matched) return true;
  return unmatched + std::min<std::size_t>(unmatched / 2, 2) + 2 <= other.unmatched(pictures) &&
         best.rms_s <= 2.0 * std::max(other.rms_s, problem.rms_floor_s);
}

}  // namespace

AlignmentResult align_times(std::span<const ShotSlot> slots, std::span<const double> pictures_s,
                            double resolution_s) {
  AlignmentResult result;
  result.best.picture_of_slot.resize(slots.size());
  if (slots.empty() || pictures_s.empty()) return result;
  // Both time axes begin at their first entries, which preserves precision.
  const double first_slot_s = slots.front().from_s;
  const double first_picture_s = pictures_s.front();
  std::vector<ShotSlot> near_slots;
  near_slots.reserve(slots.size());
  for (const ShotSlot& slot : slots) {
    near_slots.push_back({slot.from_s - first_slot_s, slot.to_s - first_slot_s});
  }
  std::vector<double> near_pictures_s;
  near_pictures_s.reserve(pictures_s.size());
  for (const double time_s : pictures_s) near_pictures_s.push_back(time_s - first_picture_s);

  const Problem problem{near_slots, near_pictures_s, tolerance(near_slots, resolution_s),
                        std::max(0.3 * resolution_s, 0.02)};
  std::vector<TimeAlignment> found = contenders(problem);
  for (TimeAlignment& each : found) each.offset_s += first_picture_s - first_slot_s;
  if (found.empty()) return result;
  const auto rival = std::find_if(found.begin() + 1, found.end(), [&](const TimeAlignment& other) {
    return !rules_out(problem, found.front(), other);
  });
  if (rival != found.end()) result.rival = *rival;
  result.best = std::move(found.front());
  return result;
}

}  // namespace raywalk::capture
