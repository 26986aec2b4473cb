#include "capture/import/video_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

constexpr double kMoving = 0.25;            // of steady motion: above this the carriage moves
constexpr double kLeastState_s = 0.4;       // shorter motions and rests are noise
constexpr double kSmoothing_s = 0.2;        // activity is averaged over this time
constexpr double kLargestMismatch_s = 0.5;  // of the offsets by single starts and stops

// Motion over time, ascending.
struct Motion {
  std::vector<double> times_s{};
  std::vector<double> values{};
};

// The carriage starts or stops.
struct Edge {
  double time_s = 0.0;
  bool starts = false;
};

struct Levels {
  double rest = 0.0;
  double steady = 0.0;
};

// The median of motion above the middle between its 2nd and 98th percentile is steady.
Levels levels_of(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t few = (values.size() - 1) / 50;
  const double rest = values[few];
  const double halfway = 0.5 * (rest + values[values.size() - 1 - few]);
  const auto moving = std::ranges::upper_bound(values, halfway);
  if (moving == values.end()) return {rest, rest};
  return {rest, *(moving + (values.end() - moving) / 2)};
}

// 0 at rest and 1 in steady motion, averaged around every time.
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

// Where motion passes kMoving and stays above or below it, in order of time.
std::vector<Edge> edges_of(const Motion& motion) {
  std::vector<Edge> edges;
  bool moves = motion.values.front() > kMoving;
  std::size_t changed = 1;  // where it began to be in the other state
  for (std::size_t i = 1; i < motion.values.size(); ++i) {
    const bool is_above = motion.values[i] > kMoving;
    if (is_above == moves) {
      changed = i + 1;
    } else if (motion.times_s[i] - motion.times_s[changed] >= kLeastState_s) {
      moves = is_above;
      const double before = motion.values[changed - 1];
      const double share = (kMoving - before) / (motion.values[changed] - before);
      edges.push_back(
          {std::lerp(motion.times_s[changed - 1], motion.times_s[changed], share), moves});
    }
  }
  return edges;
}

std::vector<Edge> edges_of(const VideoTrack& track, const std::string& video) {
  constexpr std::size_t kFewestFrames = 10;
  if (track.frames.size() <= kFewestFrames) {
    throw Error(fmt::format("{}: {} frames are too few to detect the carriage's motion", video,
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
  if (levels.steady >= 1.3 * levels.rest + kLeastRise) return edges_of(scaled(raw, levels));
  throw Error(fmt::format(
      "{}: shows no start or stop of motion (the picture changes by {:.2f} to {:.2f} grey levels "
      "from frame to frame); stay some seconds at rest before and after each line",
      video, levels.rest, levels.steady));
}

std::vector<Edge> edges_of(const Travel& travel) {
  constexpr double kStep_s = 0.02;
  Motion raw;
  for (double time_s = travel.begin_s(); time_s + kStep_s < travel.end_s(); time_s += kStep_s) {
    raw.times_s.push_back(time_s + 0.5 * kStep_s);
    raw.values.push_back(travel.speed_mm_s(time_s, time_s + kStep_s));
  }
  return edges_of(scaled(raw, {0.0, std::max(levels_of(raw.values).steady, 1e-9)}));
}

// The clock by which the video's edges are the journal's from `first` on, if they can be.
std::optional<VideoClock> clock_from(const std::vector<Edge>& video,
                                     const std::vector<Edge>& journal, std::size_t first) {
  std::vector<double> offsets_s;
  for (std::size_t i = 0; i < video.size(); ++i) {
    if (video[i].starts != journal[first + i].starts) return std::nullopt;
    offsets_s.push_back(journal[first + i].time_s - video[i].time_s);
  }
  const auto [least_s, most_s] = std::ranges::minmax(offsets_s);
  if (most_s - least_s > kLargestMismatch_s) return std::nullopt;
  return VideoClock{.offset_s = 0.5 * (offsets_s.front() + offsets_s.back()),
                    .uncertainty_s = 0.5 * (most_s - least_s)};
}

// Position of a frame on a line.
struct PlacedFrame {
  StationFrame frame{};
  std::string line{};
  double error_mm = 0.0;  // by the uncertainty of the clock
  bool blurred = false;
};

std::vector<PlacedFrame> place_frames(const VideoTrack& track, std::span<const Travel> travels,
                                      const VideoClock& clock) {
  constexpr double kSpeedOver_s = 0.05;
  const std::vector<bool> blurred = blurred_frames(track);
  std::vector<PlacedFrame> placed;
  for (std::size_t i = 0; i < track.frames.size(); ++i) {
    const double time_s = track.frames[i].time_s + clock.offset_s;
    for (const Travel& travel : travels) {
      const std::optional<double> position_mm = travel.position_mm(time_s);
      if (!position_mm) continue;
      const double speed_mm_s =
          travel.speed_mm_s(time_s - 0.5 * kSpeedOver_s, time_s + 0.5 * kSpeedOver_s);
      placed.push_back({{0, i, time_s, *position_mm},
                        travel.line,
                        speed_mm_s * clock.uncertainty_s,
                        blurred[i]});
      break;
    }
  }
  return placed;
}

// Half the distance to the nearer neighbour on the same line.
double reach_mm(const std::vector<SessionStation>& stations, std::size_t of) {
  double nearest_mm = HUGE_VAL;
  for (const std::size_t other : {of - 1, of + 1}) {
    if (other >= stations.size() || stations[other].line != stations[of].line) continue;
    nearest_mm =
        std::min(nearest_mm, std::abs(stations[other].planned_mm - stations[of].planned_mm));
  }
  return 0.5 * nearest_mm;
}

// Prevents a frame from being assigned to the wrong station.
void require_certain(const PlacedFrame& frame, double within_mm, const VideoClock& clock,
                     const std::string& video) {
  if (frame.error_mm < within_mm) return;
  throw Error(fmt::format(
      "{}: the clock offset is only known to {:.2f} s, or {:.1f} mm of travel, and stations are "
      "{:.1f} mm apart; move more slowly, with some seconds at rest before and after each line",
      video, clock.uncertainty_s, frame.error_mm, 2.0 * within_mm));
}

}  // namespace

std::optional<double> Travel::position_mm(double time_s) const {
  if (time_s < begin_s() || time_s > end_s()) return std::nullopt;
  const auto after = std::ranges::upper_bound(times_s, time_s);
  if (after == times_s.begin()) return positions_mm.front();
  if (after == times_s.end()) return positions_mm.back();
  const auto i = static_cast<std::size_t>(after - times_s.begin());
  const double share = (time_s - times_s[i - 1]) / (times_s[i] - times_s[i - 1]);
  return std::lerp(positions_mm[i - 1], positions_mm[i], share);
}

double Travel::speed_mm_s(double from_s, double to_s) const {
  const double from_mm = position_mm(std::clamp(from_s, begin_s(), end_s())).value();
  const double to_mm = position_mm(std::clamp(to_s, begin_s(), end_s())).value();
  return std::abs(to_mm - from_mm) / (to_s - from_s);
}

std::vector<Travel> travels_of(const std::string& line, std::span<const JournalSample> journal,
                               WallTime start) {
  constexpr double kLongestGap_s = 1.0;
  std::vector<Travel> travels;
  for (const JournalSample& sample : journal) {
    const double time_s = std::chrono::duration<double>(sample.time - start).count();
    if (!travels.empty() && time_s <= travels.back().times_s.back()) continue;
    if (travels.empty() || time_s > travels.back().times_s.back() + kLongestGap_s) {
      travels.push_back({.line = line});
    }
    travels.back().times_s.push_back(time_s);
    travels.back().positions_mm.push_back(sample.position_mm);
  }
  std::erase_if(travels, [](const Travel& travel) { return travel.times_s.size() < 2; });
  return travels;
}

VideoClock match_video_clock(const VideoTrack& track, std::span<const Travel> travels,
                             const std::string& video) {
  const std::vector<Edge> shown = edges_of(track, video);
  std::vector<Edge> recorded;
  for (const Travel& travel : travels) {
    const std::vector<Edge> edges = edges_of(travel);
    recorded.insert(recorded.end(), edges.begin(), edges.end());
  }
  std::vector<VideoClock> clocks;
  for (std::size_t first = 0; !shown.empty() && first + shown.size() <= recorded.size(); ++first) {
    if (const auto clock = clock_from(shown, recorded, first)) clocks.push_back(*clock);
  }
  if (clocks.empty()) {
    throw Error(fmt::format(
        "{}: the motion, with {} starts and stops, does not fit the journal at any time; is it the "
        "video of another session? Cut parts in which the camera is carried",
        video, shown.size()));
  }
  if (clocks.size() > 1) {
    throw Error(fmt::format(
        "{}: the motion fits the journal at two times, {:.1f} s apart; name the recorded line with "
        "--line",
        video, clocks[1].offset_s - clocks[0].offset_s));
  }
  const double frame_s = track.frames.back().time_s / static_cast<double>(track.frames.size() - 1);
  clocks[0].uncertainty_s += 0.5 * frame_s;
  return clocks[0];
}

VideoStations find_station_frames(const SessionContents& contents, const VideoTrack& track,
                                  std::span<const Travel> travels, const VideoClock& clock,
                                  const std::string& video) {
  VideoStations result;
  const std::vector<PlacedFrame> frames = place_frames(track, travels, clock);
  std::set<std::string> lines;
  for (const PlacedFrame& frame : frames) lines.insert(frame.line);

  for (std::size_t i = 0; i < contents.stations.size(); ++i) {
    const SessionStation& station = contents.stations[i];
    const std::string& line = contents.line_of(station).id;
    if (!lines.contains(line)) continue;
    if (station.shot && !station.shot->on_card) {
      ++result.captured_before;
      continue;
    }
    const double within_mm = reach_mm(contents.stations, i);
    const auto error_mm = [&](const PlacedFrame& each) {
      const double off_mm = std::abs(each.frame.position_mm - station.planned_mm);
      return each.line == line && off_mm < within_mm ? off_mm + each.error_mm : HUGE_VAL;
    };
    const auto sharp_error_mm = [&](const PlacedFrame& each) {
      return each.blurred ? HUGE_VAL : error_mm(each);
    };
    const PlacedFrame& nearest = *std::ranges::min_element(frames, {}, error_mm);
    const PlacedFrame& sharp = *std::ranges::min_element(frames, {}, sharp_error_mm);
    if (error_mm(nearest) == HUGE_VAL) {
      result.missing.push_back(station.name);
    } else if (sharp_error_mm(sharp) == HUGE_VAL) {
      result.only_blurred.push_back(station.name);
    } else {
      require_certain(sharp, within_mm, clock, video);
      const double off_mm = std::abs(sharp.frame.position_mm - station.planned_mm);
      result.farthest_mm = std::max(result.farthest_mm, off_mm);
      result.uncertainty_mm = std::max(result.uncertainty_mm, sharp.error_mm);
      if (nearest.blurred) ++result.blurred_skipped;
      result.found.push_back(sharp.frame);
      result.found.back().station = i;
    }
  }
  std::ranges::sort(result.found, {}, &StationFrame::frame);
  return result;
}

}  // namespace raywalk::capture
