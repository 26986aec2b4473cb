#include "capture/import/match_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <utility>

#include "capture/import/name_list.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// Largest variation of a camera's shutter lag from shot to shot.
constexpr double kLagJitter_s = 0.4;
// Two consumer quartz clocks, each off by 100 ppm, in opposite directions.
constexpr double kMostDrift = 2e-4;

// An expected picture: taken within [from_s, to_s] of the session's clock. Exposures of one bracket
// share their interval.
struct Slot {
  double from_s = 0.0;
  double to_s = 0.0;

  double middle_s() const { return 0.5 * (from_s + to_s); }
};

// All times in seconds since the first station, each by its own clock.
struct Times {
  std::vector<Slot> slots;         // ascending
  std::vector<double> pictures_s;  // ascending
  double tolerance_s = 0.0;        // of a picture from its slot
  double rms_floor_s = 0.0;        // residuals below this are not compared

  // From a picture to the interval of a slot; 0 inside it.
  double residual_s(const CameraClock& clock, std::size_t slot, std::size_t picture) const {
    const Slot& interval = slots[slot];
    const double time_s = pictures_s[picture] - clock.offset_s - clock.drift * interval.middle_s();
    return std::max({interval.from_s - time_s, time_s - interval.to_s, 0.0});
  }
  bool same_bracket(std::size_t slot, std::size_t next) const {
    return next < slots.size() && slots[next].from_s == slots[slot].from_s;
  }
};

// Pictures assigned to slots, with the clock that fits them.
struct Pairing {
  std::vector<std::optional<std::size_t>> picture_of_slot{};  // ascending
  std::size_t matched = 0;
  std::size_t unmatched = 0;  // slots plus pictures without counterpart
  CameraClock clock{};
};

// A picture may be off by half a step of its clock plus the camera's jitter, but not by more than
// half a pause between slots (the 5th percentile), beyond which it is nearer to another slot.
double tolerance_of(const Times& times, double resolution_s) {
  std::vector<double> pauses_s;
  for (std::size_t i = 1; i < times.slots.size(); ++i) {
    if (times.same_bracket(i - 1, i)) continue;
    pauses_s.push_back(times.slots[i].from_s - times.slots[i - 1].to_s);
  }
  std::ranges::sort(pauses_s);
  const double short_s = pauses_s.empty() ? HUGE_VAL : pauses_s[pauses_s.size() / 20];
  return std::min(0.5 * resolution_s + kLagJitter_s, std::max(0.45 * short_s, 0.25 * resolution_s));
}

Times times_of(const SessionShots& session, const CardPictures& card) {
  const WallTime first = session.stations.front().from;
  const auto seconds = [&](WallTime time) {
    return std::chrono::duration<double>(time - first).count();
  };
  Times times;
  for (const ExposedStation& station : session.stations) {
    times.slots.insert(times.slots.end(), static_cast<std::size_t>(session.exposures),
                       {seconds(station.from), seconds(station.to)});
  }
  for (const CardShot& shot : card.shots) times.pictures_s.push_back(seconds(shot[0].time));
  times.tolerance_s = tolerance_of(times, card.resolution_s);
  times.rms_floor_s = std::max(0.3 * card.resolution_s, 0.02);
  return times;
}

// Gives every slot, in order, the nearest picture within the tolerance.
void assign(const Times& times, Pairing* pairing) {
  const std::size_t pictures = times.pictures_s.size();
  CameraClock& clock = pairing->clock;
  pairing->picture_of_slot.assign(times.slots.size(), std::nullopt);
  pairing->matched = 0;
  double squares = 0.0;
  std::size_t picture = 0;
  for (std::size_t slot = 0; slot < times.slots.size(); ++slot) {
    const double shift_s = clock.offset_s + clock.drift * times.slots[slot].middle_s();
    const double earliest_s = times.slots[slot].from_s + shift_s - times.tolerance_s;
    while (picture < pictures && times.pictures_s[picture] < earliest_s) ++picture;
    // The next picture may be nearer, unless it is the next exposure of the same bracket.
    while (!times.same_bracket(slot, slot + 1) && picture + 1 < pictures &&
           times.residual_s(clock, slot, picture + 1) < times.residual_s(clock, slot, picture)) {
      ++picture;
    }
    if (picture == pictures) break;
    const double off_s = times.residual_s(clock, slot, picture);
    if (off_s > times.tolerance_s) continue;
    squares += off_s * off_s;
    ++pairing->matched;
    pairing->picture_of_slot[slot] = picture++;
  }
  pairing->unmatched = times.slots.size() + pictures - 2 * pairing->matched;
  clock.rms_s = std::sqrt(squares / std::max(1.0, static_cast<double>(pairing->matched)));
}

// Fits the clock to the pairs by least squares. As short sessions do not determine the drift, it is
// drawn to 0 as if 1000 s of the usual scatter had been seen without any.
void fit_clock(const Times& times, Pairing* pairing) {
  constexpr double kPrior_s2 = 6000.0 * 6000.0;  // (scatter of 0.3 s / usual drift of 5e-5)^2
  double count = 0.0, sum_s = 0.0, sum_ahead_s = 0.0, squares = 0.0, products = 0.0;
  for (std::size_t slot = 0; slot < times.slots.size(); ++slot) {
    const auto& picture = pairing->picture_of_slot[slot];
    if (!picture) continue;
    const double slot_s = times.slots[slot].middle_s();
    const double ahead_s = times.pictures_s[*picture] - slot_s - pairing->clock.offset_s;
    count += 1.0;
    sum_s += slot_s;
    sum_ahead_s += ahead_s;
    squares += slot_s * slot_s;
    products += slot_s * ahead_s;
  }
  const double drift =
      (products - sum_s * sum_ahead_s / count) / (squares - sum_s * sum_s / count + kPrior_s2);
  pairing->clock.drift = std::clamp(drift, -kMostDrift, kMostDrift);
  pairing->clock.offset_s += (sum_ahead_s - pairing->clock.drift * sum_s) / count;
}

// The offsets that most pairs of a slot and a picture have, also those wrong by a few slots. They
// are counted in steps of the tolerance, two steps at a time, so that no cluster is split.
std::vector<double> likely_offsets(const Times& times) {
  constexpr std::size_t kSlots = 300;  // of more, some do not vote
  constexpr std::size_t kOffsets = 40;
  std::map<double, int> votes;  // by step
  for (std::size_t slot = 0; slot < times.slots.size(); slot += 1 + times.slots.size() / kSlots) {
    for (const double picture_s : times.pictures_s) {
      const double offset_s = picture_s - times.slots[slot].middle_s();
      const double step = std::floor(offset_s / times.tolerance_s);
      ++votes[step];
      ++votes[step + 1.0];
    }
  }
  std::vector<std::pair<int, double>> counted;
  counted.reserve(votes.size());
  for (const auto& [step, count] : votes) counted.emplace_back(count, step * times.tolerance_s);
  std::ranges::sort(counted, std::greater<>());
  counted.resize(std::min(counted.size(), kOffsets));
  std::vector<double> offsets_s(counted.size());
  std::ranges::transform(counted, offsets_s.begin(), &std::pair<int, double>::second);
  return offsets_s;
}

// The distinct pairings that likely offsets lead to, best first. Where the drift moves pictures by
// more than the tolerance, as over a night, drifts are tried in steps of that.
std::vector<Pairing> find_pairings(const Times& times) {
  constexpr double kUsualDrift = 1e-4;
  constexpr int kMostSteps = 100;
  constexpr int kFits = 4;
  const double drift_s = kUsualDrift * times.slots.back().from_s;
  const int steps = static_cast<int>(std::min<double>(kMostSteps, drift_s / times.tolerance_s));
  std::vector<Pairing> found;
  for (const double offset_s : likely_offsets(times)) {
    for (int step = -steps; step <= steps; ++step) {
      const double drift = kUsualDrift * step / std::max(1, steps);
      Pairing pairing{.clock = {.offset_s = offset_s, .drift = drift}};
      assign(times, &pairing);
      for (int i = 0; i < kFits && pairing.matched > 0; ++i) {
        fit_clock(times, &pairing);
        assign(times, &pairing);
      }
      const bool is_known = std::ranges::any_of(found, [&](const Pairing& other) {
        return other.picture_of_slot == pairing.picture_of_slot;
      });
      if (pairing.matched > 0 && !is_known) found.push_back(std::move(pairing));
    }
  }
  std::ranges::sort(found, {}, [](const Pairing& pairing) {
    return std::pair(pairing.unmatched, pairing.clock.rms_s);
  });
  return found;
}

// Whether `best` leaves no doubt about another that leaves as many unmatched, or more. With n
// unmatched, it does if the other leaves at least n + min(n/2, 2) + 2, or has twice the residual.
bool rules_out(const Pairing& best, const Pairing& other, double rms_floor_s) {
  if (other.clock.rms_s > 2.0 * std::max(best.clock.rms_s, rms_floor_s)) return true;
  return best.unmatched + std::min<std::size_t>(best.unmatched / 2, 2) + 2 <= other.unmatched;
}

std::string shot_name(const CardShot& shot) { return shot.front().file.filename().string(); }

std::vector<std::size_t> by_name(const CardPictures& card) {
  std::vector<std::size_t> order(card.shots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t shot) { return shot_name(card.shots[shot]); });
  return order;
}

// Where the camera's clock was set between two pictures, if there are as many as the stations
// expect and every other pair is as far apart by both clocks; else empty.
std::string clock_jump(const SessionShots& session, const CardPictures& card, const Times& times) {
  constexpr double kLeastJump_s = 60.0;
  const std::vector<std::size_t> order = by_name(card);
  if (order.size() != times.slots.size()) return "";
  std::string jump;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const Slot& slot = times.slots[i];
    const double step_s = times.pictures_s[order[i]] - times.pictures_s[order[i - 1]] -
                          (slot.from_s - times.slots[i - 1].from_s);
    if (std::abs(step_s) < 2.0 + 2.0 * card.resolution_s + slot.to_s - slot.from_s) continue;
    if (std::abs(step_s) < kLeastJump_s || !jump.empty()) return "";
    jump = fmt::format(
        "the camera's clock jumps by {:+.0f} s between {} and {}; if no picture is missing, "
        "'--station {}' assigns them in order of their names",
        step_s, shot_name(card.shots[order[i - 1]]), shot_name(card.shots[order[i]]),
        session.stations.front().attempt.station);
  }
  return jump;
}

// The first slot to which the two pairings assign different pictures.
[[noreturn]] void throw_ambiguous(const SessionShots& session, const CardPictures& card,
                                  const Pairing& best, const Pairing& rival) {
  const auto differ = std::ranges::mismatch(best.picture_of_slot, rival.picture_of_slot);
  const auto slot = static_cast<std::size_t>(differ.in1 - best.picture_of_slot.begin());
  const auto name = [&](const std::optional<std::size_t>& picture) {
    return picture ? shot_name(card.shots[*picture]) : std::string("none");
  };
  throw Error(fmt::format(
      "{} pictures for {}: the times do not determine the assignment ({} could have {} or {}); "
      "add the missing pictures, remove those of no station, or assign them by their names with "
      "--station",
      card.shots.size(), best.picture_of_slot.size(),
      session.stations[slot / static_cast<std::size_t>(session.exposures)].attempt.station,
      name(*differ.in1), name(*differ.in2)));
}

// The best pairing. Throws Error if another fits as well, or it is of another session.
Pairing find_pairing(const SessionShots& session, const CardPictures& card, const Times& times) {
  const std::vector<Pairing> found = find_pairings(times);
  Pairing best = found.empty() ? Pairing{} : found.front();
  const std::string jump = clock_jump(session, card, times);
  // Stations without pictures beside pictures without stations mean that the clocks do not fit.
  const std::size_t possible = std::min(times.slots.size(), card.shots.size());
  if (best.matched == 0 || 10 * best.matched < 9 * possible) {
    throw Error(fmt::format(
        "only {} of {} pictures match the {} expected of {} stations in order and time ({}); {}",
        best.matched, card.shots.size(), times.slots.size(), session.stations.size(),
        card.time_source,
        jump.empty() ? "are they of another session? Those of several days can be imported day by "
                       "day, with --allow-missing"
                     : jump));
  }
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (rules_out(best, found[i], times.rms_floor_s)) continue;
    if (!jump.empty()) throw Error(jump);
    throw_ambiguous(session, card, best, found[i]);
  }
  return best;
}

// Whether a picture was taken during an attempt that failed.
bool is_of_failed(const SessionShots& session, const CardPictures& card, double picture_s,
                  const CameraClock& clock) {
  const double time_s = (picture_s - clock.offset_s) / (1.0 + clock.drift);
  const WallTime first = session.stations.front().from;
  return std::ranges::any_of(session.failed, [&](const FailedAttempt& attempt) {
    const std::chrono::duration<double> from = attempt.from - first, to = attempt.to - first;
    return time_s >= from.count() - card.resolution_s && time_s <= to.count() + card.resolution_s;
  });
}

// "9 of 10 pictures belong to no station: R1.JPG, R2.JPG"; empty if there are no names.
std::string mismatch_text(const std::string& what, const std::vector<std::string>& names) {
  return names.empty() ? "" : what + ": " + name_list(names);
}

std::string unpaired_text(const CardPictures& card) {
  std::vector<std::string> names;
  for (const auto& file : card.unpaired) names.push_back(file.filename().string());
  return mismatch_text("front without back or back without front", names);
}

}  // namespace

PictureMatch match_pictures(const SessionShots& session, const CardPictures& card) {
  const Times times = times_of(session, card);
  const Pairing pairing = find_pairing(session, card, times);
  PictureMatch match{.clock = pairing.clock};
  // A time is the lower end of a clock step; the middle is an unbiased estimate.
  match.clock->offset_s += 0.5 * card.resolution_s;

  const auto exposures = static_cast<std::size_t>(session.exposures);
  std::vector<bool> used(card.shots.size(), false);
  std::vector<std::string> lacking;
  for (std::size_t station = 0; station < session.stations.size(); ++station) {
    std::vector<std::size_t> shots;
    for (std::size_t i = 0; i < exposures; ++i) {
      const auto& shot = pairing.picture_of_slot[station * exposures + i];
      if (!shot) continue;
      shots.push_back(*shot);
      used[*shot] = true;
    }
    const std::string& name = session.stations[station].attempt.station;
    if (shots.size() == exposures) {
      match.complete.push_back({station, std::move(shots)});
    } else if (!session.stations[station].imported) {
      lacking.push_back(
          shots.empty() ? name : fmt::format("{} ({} of {})", name, shots.size(), exposures));
    }
  }
  std::vector<std::string> surplus;
  for (std::size_t shot = 0; shot < card.shots.size(); ++shot) {
    if (used[shot]) continue;
    if (is_of_failed(session, card, times.pictures_s[shot], pairing.clock)) {
      ++match.from_failed;
    } else {
      surplus.push_back(shot_name(card.shots[shot]));
    }
  }
  std::vector<std::string> parts{
      mismatch_text(
          fmt::format("{} of {} stations lack pictures", lacking.size(), session.stations.size()),
          lacking),
      mismatch_text(
          fmt::format("{} of {} pictures belong to no station", surplus.size(), card.shots.size()),
          surplus),
      lacking.empty() ? "" : clock_jump(session, card, times), unpaired_text(card)};
  std::erase(parts, "");
  match.mismatches = fmt::format("{}", fmt::join(parts, "; "));
  return match;
}

PictureMatch assign_by_name(const SessionShots& session, const CardPictures& card,
                            const std::string& first_station) {
  const auto named =
      std::ranges::find(session.stations, first_station,
                        [](const ExposedStation& station) { return station.attempt.station; });
  if (named == session.stations.end()) {
    throw Error(fmt::format("--station: {} has no pictures on the card", excerpt(first_station)));
  }
  const auto first = static_cast<std::size_t>(named - session.stations.begin());
  const auto each = static_cast<std::size_t>(session.exposures);
  const std::size_t stations = card.shots.size() / each;
  if (stations * each != card.shots.size() || first + stations > session.stations.size()) {
    throw Error(fmt::format("{} pictures for the {} stations from {} on, {} of each",
                            card.shots.size(), session.stations.size() - first, first_station,
                            each));
  }
  PictureMatch match{.mismatches = unpaired_text(card)};
  const std::vector<std::size_t> order = by_name(card);
  for (std::size_t i = 0; i < stations; ++i) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(i * each);
    match.complete.push_back({first + i, {begin, begin + static_cast<std::ptrdiff_t>(each)}});
  }
  return match;
}

}  // namespace raywalk::capture
