#include "capture/import/match_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/import/align_times.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr std::size_t kMostNames = 8;  // in one line

double seconds_of(WallTime time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

// One slot per exposure of each station.
std::vector<ShotSlot> slots_of(const SessionShots& session) {
  std::vector<ShotSlot> slots;
  for (const ExposedStation& station : session.stations) {
    const ShotSlot slot{seconds_of(station.from), seconds_of(station.to)};
    slots.insert(slots.end(), static_cast<std::size_t>(session.exposures), slot);
  }
  return slots;
}

std::vector<double> times_of(const CardPictures& card) {
  std::vector<double> times_s;
  for (const CardShot& shot : card.shots) times_s.push_back(seconds_of(shot.time));
  return times_s;
}

std::string shot_name(const CardShot& shot) { return shot.files.front().file.filename().string(); }

// "a, b, c and 7 more".
std::string list_of(const std::vector<std::string>& names) {
  const std::size_t shown = std::min(names.size(), kMostNames);
  std::string list = fmt::format("{}", fmt::join(names.begin(), names.begin() + shown, ", "));
  if (names.size() > shown) list += fmt::format(" and {} more", names.size() - shown);
  return list;
}

std::vector<std::size_t> by_name(const CardPictures& card) {
  std::vector<std::size_t> order(card.shots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t shot) { return shot_name(card.shots[shot]); });
  return order;
}

// Where the camera's clock was set between two pictures, if there are as many as the stations
// expect and every other pair is as far apart by both clocks; else empty.
std::string clock_jump(const SessionShots& session, const CardPictures& card) {
  constexpr double kLeastJump_s = 60.0;
  const std::vector<ShotSlot> slots = slots_of(session);
  const std::vector<std::size_t> order = by_name(card);
  if (order.size() != slots.size()) return "";
  const auto ahead_s = [&](std::size_t i) {
    return seconds_of(card.shots[order[i]].time) - slots[i].from_s;
  };
  std::string jump;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const double step_s = ahead_s(i) - ahead_s(i - 1);
    if (std::abs(step_s) < 2.0 + 2.0 * card.resolution_s + slots[i].to_s - slots[i].from_s)
      continue;
    if (std::abs(step_s) < kLeastJump_s || !jump.empty()) return "";
    jump = fmt::format(
        "the camera's clock jumps by {:+.0f} s between {} and {}; if no picture is missing, "
        "'--station {}' assigns them in order of their names",
        step_s, shot_name(card.shots[order[i - 1]]), shot_name(card.shots[order[i]]),
        session.stations.front().attempt.station);
  }
  return jump;
}

// The first slot to which the two alignments assign different pictures.
[[noreturn]] void throw_ambiguous(const SessionShots& session, const CardPictures& card,
                                  const TimeAlignment& best, const TimeAlignment& rival) {
  const std::string jump = clock_jump(session, card);
  if (!jump.empty()) throw Error(jump);
  const auto per_station = static_cast<std::size_t>(session.exposures);
  for (std::size_t slot = 0; slot < best.picture_of_slot.size(); ++slot) {
    const auto& one = best.picture_of_slot[slot];
    const auto& other = rival.picture_of_slot[slot];
    if (one == other) continue;
    const std::string station = session.stations[slot / per_station].attempt.station;
    const auto name = [&](const std::optional<std::size_t>& picture) {
      return picture ? shot_name(card.shots[*picture]) : std::string("none");
    };
    throw Error(fmt::format(
        "{} pictures for {}: the times do not determine the assignment ({} could have {} or {}); "
        "add the missing pictures, remove those of no station, or assign them by their names with "
        "--station",
        card.shots.size(), best.picture_of_slot.size(), station, name(one), name(other)));
  }
  throw Error("the times do not determine which picture belongs to which station");
}

void require_same_session(const SessionShots& session, const CardPictures& card,
                          const TimeAlignment& alignment) {
  const std::size_t slots = alignment.picture_of_slot.size();
  const std::size_t fewer = std::min(slots, card.shots.size());
  if (2 * alignment.matched >= fewer && alignment.matched > 0) return;
  const std::string jump = clock_jump(session, card);
  throw Error(fmt::format(
      "only {} of {} pictures match the {} expected of {} stations in order and time ({}); {}",
      alignment.matched, card.shots.size(), slots, session.stations.size(), name_of(card.source),
      jump.empty() ? "are they of another session?" : jump));
}

// The time of a picture by the session's clock, from the fitted offset and drift.
double session_time(const CardShot& shot, const TimeAlignment& alignment, double first_slot_s) {
  const double apart_s = seconds_of(shot.time) - alignment.offset_s - first_slot_s;
  return first_slot_s + apart_s / (1.0 + alignment.drift);
}

bool is_from_failed(const SessionShots& session, double time_s, double tolerance_s) {
  return std::any_of(session.failed.begin(), session.failed.end(),
                     [&](const FailedAttempt& attempt) {
                       return time_s >= seconds_of(attempt.from) - tolerance_s &&
                              time_s <= seconds_of(attempt.to) + tolerance_s;
                     });
}

void assign_stations(const SessionShots& session, const TimeAlignment& alignment,
                     PictureMatch* match, std::vector<bool>* used) {
  const auto per_station = static_cast<std::size_t>(session.exposures);
  for (std::size_t station = 0; station < session.stations.size(); ++station) {
    StationPictures pictures{station, {}};
    for (std::size_t i = 0; i < per_station; ++i) {
      const auto& shot = alignment.picture_of_slot[station * per_station + i];
      if (!shot) continue;
      pictures.shots.push_back(*shot);
      (*used)[*shot] = true;
    }
    if (pictures.shots.size() == per_station) {
      match->complete.push_back(std::move(pictures));
    } else if (!session.stations[station].imported) {
      match->incomplete.push_back(std::move(pictures));
    }
  }
}

}  // namespace

PictureMatch match_pictures(const SessionShots& session, const CardPictures& card) {
  const std::vector<ShotSlot> slots = slots_of(session);
  const AlignmentResult result = align_times(slots, times_of(card), card.resolution_s);
  require_same_session(session, card, result.best);
  if (result.rival) throw_ambiguous(session, card, result.best, *result.rival);

  PictureMatch match;
  // A time is the lower end of a clock step; the middle is an unbiased estimate.
  match.clock_offset_s = result.best.offset_s + 0.5 * card.resolution_s;
  match.clock_drift = result.best.drift;
  match.rms_s = result.best.rms_s;
  std::vector<bool> used(card.shots.size(), false);
  assign_stations(session, result.best, &match, &used);
  for (std::size_t shot = 0; shot < card.shots.size(); ++shot) {
    if (used[shot]) continue;
    const double time_s = session_time(card.shots[shot], result.best, slots.front().from_s);
    const bool failed = is_from_failed(session, time_s, card.resolution_s);
    (failed ? match.from_failed : match.unassigned).push_back(shot);
  }
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
  PictureMatch match;
  match.by_name = true;
  const std::vector<std::size_t> order = by_name(card);
  for (std::size_t i = 0; i < stations; ++i) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(i * each);
    match.complete.push_back({first + i, {begin, begin + static_cast<std::ptrdiff_t>(each)}});
  }
  return match;
}

bool is_complete(const PictureMatch& match, const CardPictures& card) {
  return match.incomplete.empty() && match.unassigned.empty() && card.unpaired.empty();
}

std::string describe_mismatches(const PictureMatch& match, const SessionShots& session,
                                const CardPictures& card) {
  std::vector<std::string> lacking;
  for (const StationPictures& each : match.incomplete) {
    const std::string& name = session.stations[each.station].attempt.station;
    const std::size_t found = each.shots.size();
    lacking.push_back(found == 0 ? name
                                 : fmt::format("{} ({} of {})", name, found, session.exposures));
  }
  std::vector<std::string> surplus;
  for (const std::size_t shot : match.unassigned) surplus.push_back(shot_name(card.shots[shot]));
  std::vector<std::string> single;
  for (const auto& file : card.unpaired) single.push_back(file.filename().string());

  std::vector<std::string> parts;
  if (!lacking.empty()) {
    parts.push_back(fmt::format("{} of {} stations lack pictures: {}", lacking.size(),
                                session.stations.size(), list_of(lacking)));
  }
  if (!surplus.empty()) {
    parts.push_back(fmt::format("{} of {} pictures belong to no station: {}", surplus.size(),
                                card.shots.size(), list_of(surplus)));
  }
  const std::string jump = lacking.empty() ? "" : clock_jump(session, card);
  if (!jump.empty()) parts.push_back(jump);
  if (!single.empty()) {
    parts.push_back(fmt::format("front without back or back without front: {}", list_of(single)));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace raywalk::capture
