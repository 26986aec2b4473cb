#include "capture/import/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

constexpr double kMoving = 0.25;            // of steady motion: above this the carriage moves
constexpr double kLeastState_s = 0.4;       // shorter motions and rests are noise
constexpr double kSmoothing_s = 0.2;        // activity is averaged over this time
constexpr double kLargestMismatch_s = 0.5;  // of the offsets by single starts and stops

// Motion over time, ascending: 0 at rest, 1 in steady motion.
struct Motion {
  std::vector<double> times_s{};
  std::vector<double> values{};
};

// The carriage starts or stops.
struct Edge {
  double time_s = 0.0;
  bool starts = false;
};

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

struct Levels {
  double rest = 0.0;
  double steady = 0.0;
};

Levels levels_of(const std::vector<double>& values) {
  Levels levels;
  levels.rest = quantile(values, 0.02);
  const double halfway = 0.5 * (levels.rest + quantile(values, 0.98));
  std::vector<double> moving;
  for (const double value : values) {
    if (value > halfway) moving.push_back(value);
  }
  levels.steady = moving.empty() ? levels.rest : median(moving);
  return levels;
}

// Scaled to the levels, and averaged around every time.
Motion scaled(const Motion& raw, const Levels& levels) {
  Motion motion{raw.times_s, std::vector<double>(raw.values.size())};
  std::size_t first = 0, last = 0;  // of the values averaged
  double sum = 0.0;
  for (std::size_t i = 0; i < raw.values.size(); ++i) {
    const double from_s = raw.times_s[i] - 0.5 * kSmoothing_s;
    while (last < raw.values.size() && raw.times_s[last] < from_s + kSmoothing_s) {
      sum += raw.values[last++];
    }
    while (raw.times_s[first] < from_s) sum -= raw.values[first++];
    const double mean = sum / static_cast<double>(last - first);
    motion.values[i] = (mean - levels.rest) / (levels.steady - levels.rest);
  }
  return motion;
}

Motion motion_of(const FilmTrack& track, const std::string& film) {
  constexpr std::size_t kFewestFrames = 10;
  if (track.frames.size() <= kFewestFrames) {
    throw Error(fmt::format("{}: {} frames are too few to detect the carriage's motion", film,
                            track.frames.size()));
  }
  Motion raw;
  for (std::size_t i = 1; i < track.frames.size(); ++i) {
    raw.times_s.push_back(0.5 * (track.frames[i - 1].time_s + track.frames[i].time_s));
    raw.values.push_back(track.frames[i].activity);
  }
  const Levels levels = levels_of(raw.values);
  // In grey levels; well above the noise of a camera at rest.
  constexpr double kLeastRise = 0.1;
  if (levels.steady >= 1.3 * levels.rest + kLeastRise) return scaled(raw, levels);
  throw Error(fmt::format(
      "{}: shows no start or stop of motion (the picture changes by {:.2f} to {:.2f} grey levels "
      "from frame to frame); film some seconds at rest before and after each line",
      film, levels.rest, levels.steady));
}

Motion motion_of(const Travel& travel) {
  constexpr double kStep_s = 0.02;
  Motion raw;
  for (double time_s = travel.begin_s(); time_s + kStep_s < travel.end_s(); time_s += kStep_s) {
    raw.times_s.push_back(time_s + 0.5 * kStep_s);
    raw.values.push_back(travel.speed_mm_s(time_s, time_s + kStep_s));
  }
  const Levels levels = levels_of(raw.values);
  return scaled(raw, {0.0, std::max(levels.steady, 1e-9)});
}

// The times at which motion passes kMoving upwards and stays above it, after a rest.
std::vector<double> starts_of(const Motion& motion) {
  std::vector<double> starts_s;
  bool moves = motion.values.front() > kMoving;
  std::size_t changed = 1;  // where it began to be in the other state
  for (std::size_t i = 1; i < motion.values.size(); ++i) {
    const bool is_above = motion.values[i] > kMoving;
    if (is_above == moves) {
      changed = i + 1;
    } else if (motion.times_s[i] - motion.times_s[changed] >= kLeastState_s) {
      moves = is_above;
      if (!moves) continue;
      const double before = motion.values[changed - 1];
      const double share = (kMoving - before) / (motion.values[changed] - before);
      starts_s.push_back(std::lerp(motion.times_s[changed - 1], motion.times_s[changed], share));
    }
  }
  return starts_s;
}

// In order of time. A stop is a start of the motion backwards in time.
std::vector<Edge> edges_of(const Motion& motion) {
  std::vector<Edge> edges;
  for (const double time_s : starts_of(motion)) edges.push_back({time_s, true});
  Motion backwards{{}, {motion.values.rbegin(), motion.values.rend()}};
  for (auto time = motion.times_s.rbegin(); time != motion.times_s.rend(); ++time) {
    backwards.times_s.push_back(-*time);
  }
  for (const double time_s : starts_of(backwards)) edges.push_back({-time_s, false});
  std::ranges::sort(edges, {}, &Edge::time_s);
  return edges;
}

// The clock by which the film's edges are the journal's from `first` on, if they can be.
std::optional<FilmClock> clock_from(const std::vector<Edge>& film, const std::vector<Edge>& journal,
                                    std::size_t first) {
  double least_s = HUGE_VAL, most_s = -HUGE_VAL;
  for (std::size_t i = 0; i < film.size(); ++i) {
    if (film[i].starts != journal[first + i].starts) return std::nullopt;
    const double offset_s = journal[first + i].time_s - film[i].time_s;
    least_s = std::min(least_s, offset_s);
    most_s = std::max(most_s, offset_s);
  }
  if (most_s - least_s > kLargestMismatch_s) return std::nullopt;
  const double by_first_s = journal[first].time_s - film.front().time_s;
  const double by_last_s = journal[first + film.size() - 1].time_s - film.back().time_s;
  return FilmClock{.offset_s = 0.5 * (by_first_s + by_last_s),
                   .uncertainty_s = 0.5 * (most_s - least_s)};
}

}  // namespace

FilmClock match_film_clock(const FilmTrack& track, std::span<const Travel> travels,
                           const std::string& film) {
  const std::vector<Edge> shown = edges_of(motion_of(track, film));
  std::vector<Edge> recorded;
  for (const Travel& travel : travels) {
    const std::vector<Edge> edges = edges_of(motion_of(travel));
    recorded.insert(recorded.end(), edges.begin(), edges.end());
  }
  std::vector<FilmClock> clocks;
  for (std::size_t first = 0; !shown.empty() && first + shown.size() <= recorded.size(); ++first) {
    if (const auto clock = clock_from(shown, recorded, first)) clocks.push_back(*clock);
  }
  if (clocks.empty()) {
    throw Error(fmt::format(
        "{}: the motion, with {} starts and stops, does not fit the journal at any time; is it the "
        "film of another session? Cut parts in which the camera is carried",
        film, shown.size()));
  }
  if (clocks.size() > 1) {
    throw Error(fmt::format(
        "{}: the motion fits the journal at two times, {:.1f} s apart; name the filmed line with "
        "--line",
        film, clocks[1].offset_s - clocks[0].offset_s));
  }
  const double frame_s = track.frames.back().time_s / static_cast<double>(track.frames.size() - 1);
  clocks[0].uncertainty_s += 0.5 * frame_s;
  return clocks[0];
}

}  // namespace raywalk::capture
