#include "capture/import/align_times.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/median.h"

namespace raywalk::capture {
namespace {

// Largest variation of a camera's shutter lag from shot to shot.
constexpr double kLagJitter_s = 0.4;
// Two consumer quartz clocks, each off by 100 ppm, in opposite directions.
constexpr double kMostDrift = 2e-4;
constexpr double kUsualDrift = 5e-5;
constexpr double kScatter_s = 0.3;              // of a clock that counts seconds: 1 / sqrt(12)
constexpr std::size_t kVotingSlots = 300;       // subsampled beyond this many
constexpr std::size_t kProposalsPerDrift = 24;  // includes offsets wrong by a few slots
constexpr int kRefinements = 3;

// Picture time = slot time + offset_s + drift * slot time.
struct ClockRelation {
  double offset_s = 0.0;
  double drift = 0.0;

  double slot_time(double picture_s, double near_slot_s) const {
    return picture_s - offset_s - drift * near_slot_s;
  }
};

double middle_of(const ShotSlot& slot) { return 0.5 * (slot.from_s + slot.to_s); }

struct Problem {
  std::span<const ShotSlot> slots;
  std::span<const double> pictures_s;
  double tolerance_s = 0.0;
  double rms_floor_s = 0.0;  // residuals below this are not compared
};

// Distance in time of a picture from the interval of a slot; 0 inside it.
double residual(const Problem& problem, const ClockRelation& clocks, std::size_t slot,
                std::size_t picture) {
  const ShotSlot& interval = problem.slots[slot];
  const double time_s = clocks.slot_time(problem.pictures_s[picture], middle_of(interval));
  return std::max({interval.from_s - time_s, time_s - interval.to_s, 0.0});
}

// The 5th percentile of the pauses between slots.
double short_pause(std::span<const ShotSlot> slots) {
  std::vector<double> pauses_s;
  for (std::size_t i = 1; i < slots.size(); ++i) {
    const bool same_bracket = slots[i].from_s == slots[i - 1].from_s;
    if (!same_bracket) pauses_s.push_back(slots[i].from_s - slots[i - 1].to_s);
  }
  if (pauses_s.empty()) return HUGE_VAL;
  const auto at = pauses_s.begin() + static_cast<std::ptrdiff_t>(pauses_s.size() / 20);
  std::nth_element(pauses_s.begin(), at, pauses_s.end());
  return *at;
}

// A picture may be off by half a step of its clock plus the camera's jitter, but not by more than
// half a pause, beyond which it is nearer to another slot.
double tolerance(std::span<const ShotSlot> slots, double resolution_s) {
  return std::min(0.5 * resolution_s + kLagJitter_s,
                  std::max(0.45 * short_pause(slots), 0.25 * resolution_s));
}

// Longest chain of pairs ascending in slot and picture; the pair that ends each chain is a node.
class ChainSearch {
 public:
  ChainSearch(std::size_t slots, std::size_t pictures)
      : slots_(slots), best_until_(pictures + 1, kNone) {}

  // Add pairs in ascending order of slots and, within a slot, in descending order of pictures, so
  // that no chain uses a slot twice.
  void add_pair(std::size_t slot, std::size_t picture, double residual_s) {
    Node node{slot, picture, 1, residual_s * residual_s, best_before(picture)};
    if (node.previous != kNone) {
      node.length += nodes_[node.previous].length;
      node.cost += nodes_[node.previous].cost;
    }
    nodes_.push_back(node);
    offer(picture, nodes_.size() - 1);
  }

  std::vector<std::optional<std::size_t>> best_chain() const {
    std::vector<std::optional<std::size_t>> picture_of_slot(slots_);
    std::size_t at = best_before(best_until_.size() - 1);
    for (; at != kNone; at = nodes_[at].previous) {
      picture_of_slot[nodes_[at].slot] = nodes_[at].picture;
    }
    return picture_of_slot;
  }

 private:
  struct Node {
    std::size_t slot;
    std::size_t picture;
    std::size_t length;
    double cost;
    std::size_t previous;
  };
  static constexpr std::size_t kNone = SIZE_MAX;

  bool is_better(std::size_t a, std::size_t b) const {
    if (a == kNone || b == kNone) return b == kNone && a != kNone;
    if (nodes_[a].length != nodes_[b].length) return nodes_[a].length > nodes_[b].length;
    return nodes_[a].cost < nodes_[b].cost;
  }

  // A Fenwick tree over pictures: entry i holds the best chain that ends in the pictures
  // (i - lowest bit of i, i], counted from 1.
  std::size_t best_before(std::size_t picture) const {
    std::size_t best = kNone;
    for (std::size_t i = picture; i > 0; i &= i - 1) {
      if (is_better(best_until_[i], best)) best = best_until_[i];
    }
    return best;
  }
  void offer(std::size_t picture, std::size_t node) {
    for (std::size_t i = picture + 1; i < best_until_.size(); i += i & (~i + 1)) {
      if (is_better(node, best_until_[i])) best_until_[i] = node;
    }
  }

  std::size_t slots_;
  std::vector<std::size_t> best_until_;
  std::vector<Node> nodes_;
};

std::vector<std::optional<std::size_t>> assign(const Problem& problem, const ClockRelation& clocks,
                                               double tolerance_s) {
  ChainSearch search(problem.slots.size(), problem.pictures_s.size());
  const auto begin = problem.pictures_s.begin();
  for (std::size_t slot = 0; slot < problem.slots.size(); ++slot) {
    const ShotSlot& interval = problem.slots[slot];
    const double shift_s = clocks.offset_s + clocks.drift * middle_of(interval);
    const auto first =
        std::lower_bound(begin, problem.pictures_s.end(), interval.from_s + shift_s - tolerance_s);
    const auto last =
        std::upper_bound(first, problem.pictures_s.end(), interval.to_s + shift_s + tolerance_s);
    for (auto picture = last; picture != first;) {
      --picture;
      const auto index = static_cast<std::size_t>(picture - begin);
      search.add_pair(slot, index, residual(problem, clocks, slot, index));
    }
  }
  return search.best_chain();
}

struct PairedTime {
  double slot_s;
  double difference_s;  // picture minus slot
};

std::vector<PairedTime> paired_times(const Problem& problem,
                                     const std::vector<std::optional<std::size_t>>& assignment) {
  std::vector<PairedTime> pairs;
  for (std::size_t slot = 0; slot < assignment.size(); ++slot) {
    if (!assignment[slot]) continue;
    const double slot_s = middle_of(problem.slots[slot]);
    pairs.push_back({slot_s, problem.pictures_s[*assignment[slot]] - slot_s});
  }
  return pairs;
}

// Maximum a posteriori drift: normal prior of standard deviation kUsualDrift, differences with
// standard deviation kScatter_s. Minimizing
//   sum (difference - mean - drift (slot - mean))^2 / kScatter_s^2 + drift^2 / kUsualDrift^2
// over drift gives S_xy / (S_xx + (kScatter_s / kUsualDrift)^2). The prior dominates in sessions of
// minutes, the data in sessions of hours. Outliers are bounded by the tolerance.
double drift_of(const std::vector<PairedTime>& pairs) {
  const auto count = static_cast<double>(pairs.size());
  double slot_mean_s = 0.0;
  double difference_mean_s = 0.0;
  for (const PairedTime& pair : pairs) {
    slot_mean_s += pair.slot_s / count;
    difference_mean_s += pair.difference_s / count;
  }
  double s_xx = 0.0;
  double s_xy = 0.0;
  for (const PairedTime& pair : pairs) {
    const double x_s = pair.slot_s - slot_mean_s;
    s_xx += x_s * x_s;
    s_xy += x_s * (pair.difference_s - difference_mean_s);
  }
  constexpr double kPrior_s2 = (kScatter_s / kUsualDrift) * (kScatter_s / kUsualDrift);
  return std::clamp(s_xy / (s_xx + kPrior_s2), -kMostDrift, kMostDrift);
}

// The median is robust to wrongly matched pictures.
ClockRelation fit_clocks(const std::vector<PairedTime>& pairs) {
  ClockRelation clocks;
  clocks.drift = drift_of(pairs);
  std::vector<double> offsets_s;
  offsets_s.reserve(pairs.size());
  for (const PairedTime& pair : pairs) {
    offsets_s.push_back(pair.difference_s - clocks.drift * pair.slot_s);
  }
  clocks.offset_s = median(offsets_s);
  return clocks;
}

// Alternates between assigning pictures and fitting the clocks, starting at a proposal.
std::optional<TimeAlignment> refine(const Problem& problem, ClockRelation clocks) {
  TimeAlignment alignment;
  for (int round = 0; round < kRefinements; ++round) {
    const bool first = round == 0;
    alignment.picture_of_slot =
        assign(problem, clocks, first ? 1.5 * problem.tolerance_s : problem.tolerance_s);
    const std::vector<PairedTime> pairs = paired_times(problem, alignment.picture_of_slot);
    if (pairs.empty()) return std::nullopt;
    alignment.matched = pairs.size();
    if (round + 1 < kRefinements) clocks = fit_clocks(pairs);
  }
  double squares = 0.0;
  for (std::size_t slot = 0; slot < alignment.picture_of_slot.size(); ++slot) {
    if (!alignment.picture_of_slot[slot]) continue;
    const double each_s = residual(problem, clocks, slot, *alignment.picture_of_slot[slot]);
    squares += each_s * each_s;
  }
  alignment.rms_s = std::sqrt(squares / static_cast<double>(alignment.matched));
  alignment.offset_s = clocks.offset_s;
  alignment.drift = clocks.drift;
  return alignment;
}

// Candidate drifts, spaced so that the offset at the end of the session changes by less than the
// tolerance from one to the next. Includes 0.
std::vector<double> drifts_to_try(const Problem& problem) {
  const double span_s = problem.slots.back().to_s - problem.slots.front().from_s;
  const int to_each_side = static_cast<int>(
      std::min(100.0, std::floor(0.5 + kMostDrift * span_s / problem.tolerance_s)));
  std::vector<double> drifts;
  for (int i = -to_each_side; i <= to_each_side; ++i) {
    drifts.push_back(to_each_side == 0 ? 0.0 : kMostDrift * i / to_each_side);
  }
  return drifts;
}

// The offsets with most votes. Bins are as wide as the tolerance; each is counted together with its
// upper neighbour, so that no cluster is split at a bin's edge.
std::vector<ClockRelation> propose_offsets(const Problem& problem, double drift) {
  const std::size_t stride = (problem.slots.size() + kVotingSlots - 1) / kVotingSlots;
  std::vector<std::int64_t> votes;
  for (std::size_t slot = 0; slot < problem.slots.size(); slot += stride) {
    const double slot_s = middle_of(problem.slots[slot]);
    for (const double picture_s : problem.pictures_s) {
      const double offset_s = picture_s - slot_s - drift * slot_s;
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
  const auto kept = std::min(counted.size(), kProposalsPerDrift);
  std::partial_sort(counted.begin(), counted.begin() + static_cast<std::ptrdiff_t>(kept),
                    counted.end(), std::greater<>());
  std::vector<ClockRelation> proposals;
  for (std::size_t i = 0; i < kept; ++i) {
    proposals.push_back(
        {(static_cast<double>(counted[i].second) + 1.0) * problem.tolerance_s, drift});
  }
  return proposals;
}

// All distinct assignments reached from the proposals that match at least half as many slots as the
// best of them.
std::vector<TimeAlignment> contenders(const Problem& problem) {
  std::vector<TimeAlignment> found;
  std::size_t fullest = 0;
  for (const double drift : drifts_to_try(problem)) {
    for (const ClockRelation& proposal : propose_offsets(problem, drift)) {
      auto alignment = refine(problem, proposal);
      if (!alignment) continue;
      fullest = std::max(fullest, alignment->matched);
      const bool known = std::any_of(found.begin(), found.end(), [&](const TimeAlignment& other) {
        return other.picture_of_slot == alignment->picture_of_slot;
      });
      if (!known) found.push_back(std::move(*alignment));
    }
  }
  std::erase_if(found, [&](const TimeAlignment& each) { return 2 * each.matched < fullest; });
  return found;
}

bool fits_twice_as_badly(const Problem& problem, const TimeAlignment& a, const TimeAlignment& b) {
  return a.rms_s > 2.0 * std::max(b.rms_s, problem.rms_floor_s);
}

bool refutes(const Problem& problem, const TimeAlignment& a, const TimeAlignment& b) {
  const std::size_t a_unmatched = a.unmatched(problem.pictures_s.size());
  const std::size_t b_unmatched = b.unmatched(problem.pictures_s.size());
  if (a_unmatched <= b_unmatched && fits_twice_as_badly(problem, b, a)) return true;
  return a_unmatched + std::min<std::size_t>(a_unmatched / 2, 2) + 2 <= b_unmatched &&
         !fits_twice_as_badly(problem, a, b);
}

// Undoes the shift of both time axes to their first entries, which preserves precision.
TimeAlignment shifted_back(TimeAlignment alignment, double first_slot_s, double first_picture_s) {
  alignment.offset_s += first_picture_s - first_slot_s;
  return alignment;
}

}  // namespace

AlignmentResult align_times(std::span<const ShotSlot> slots, std::span<const double> pictures_s,
                            double resolution_s) {
  AlignmentResult result;
  result.best.picture_of_slot.resize(slots.size());
  if (slots.empty() || pictures_s.empty()) return result;
  const double first_slot_s = slots.front().from_s;
  const double first_picture_s = pictures_s.front();
  std::vector<ShotSlot> near_slots;
  for (const ShotSlot& slot : slots) {
    near_slots.push_back({slot.from_s - first_slot_s, slot.to_s - first_slot_s});
  }
  std::vector<double> near_pictures_s;
  for (const double time_s : pictures_s) near_pictures_s.push_back(time_s - first_picture_s);

  const Problem problem{near_slots, near_pictures_s, tolerance(near_slots, resolution_s),
                        std::max(0.3 * resolution_s, 0.02)};
  std::vector<TimeAlignment> found = contenders(problem);
  if (found.empty()) return result;
  std::sort(found.begin(), found.end(), [&](const TimeAlignment& a, const TimeAlignment& b) {
    return std::pair(a.unmatched(pictures_s.size()), a.rms_s) <
           std::pair(b.unmatched(pictures_s.size()), b.rms_s);
  });
  result.best = shifted_back(found.front(), first_slot_s, first_picture_s);
  const auto rival = std::find_if(found.begin() + 1, found.end(), [&](const TimeAlignment& other) {
    return !refutes(problem, found.front(), other);
  });
  if (rival != found.end()) result.rival = shifted_back(*rival, first_slot_s, first_picture_s);
  return result;
}

}  // namespace raywalk::capture
