#include "capture/import/film_stations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>

namespace raywalk::capture {
namespace {

// Position of a frame on a line.
struct PlacedFrame {
  std::size_t frame = 0;
  const Travel* travel = nullptr;
  double time_s = 0.0;
  double position_mm = 0.0;
  double speed_mm_s = 0.0;
  bool blurred = false;
};

std::vector<PlacedFrame> place_frames(const FilmTrack& track, std::span<const Travel> travels,
                                      const FilmClock& clock) {
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
      placed.push_back({i, &travel, time_s, *position_mm, speed_mm_s, blurred[i]});
      break;
    }
  }
  return placed;
}

// Half the distance to the nearer neighbour on the same line.
double reach_mm(const std::vector<SessionStation>& stations, std::size_t of) {
  double nearest_mm = std::numeric_limits<double>::infinity();
  for (const std::size_t other : {of - 1, of + 1}) {
    if (other >= stations.size() || stations[other].line != stations[of].line) continue;
    nearest_mm =
        std::min(nearest_mm, std::abs(stations[other].planned_mm - stations[of].planned_mm));
  }
  return 0.5 * nearest_mm;
}

struct Choice {
  const PlacedFrame* sharp = nullptr;
  const PlacedFrame* any = nullptr;
};

Choice choose(const SessionContents& contents, std::size_t index,
              const std::vector<PlacedFrame>& frames, double uncertainty_s) {
  const SessionStation& station = contents.stations[index];
  const std::string& line = contents.line_of(station).id;
  const double within_mm = reach_mm(contents.stations, index);
  Choice choice;
  double least_any_mm = std::numeric_limits<double>::infinity();
  double least_sharp_mm = least_any_mm;
  for (const PlacedFrame& frame : frames) {
    const double off_mm = std::abs(frame.position_mm - station.planned_mm);
    if (frame.travel->line() != line || off_mm >= within_mm) continue;
    const double error_mm = off_mm + frame.speed_mm_s * uncertainty_s;
    if (error_mm < least_any_mm) {
      least_any_mm = error_mm;
      choice.any = &frame;
    }
    if (!frame.blurred && error_mm < least_sharp_mm) {
      least_sharp_mm = error_mm;
      choice.sharp = &frame;
    }
  }
  return choice;
}

}  // namespace

FilmStations find_station_frames(const SessionContents& contents, const FilmTrack& track,
                                 std::span<const Travel> travels, const FilmClock& clock) {
  const std::vector<PlacedFrame> frames = place_frames(track, travels, clock);
  std::set<std::string> lines;
  for (const PlacedFrame& frame : frames) lines.insert(frame.travel->line());

  FilmStations result;
  for (std::size_t i = 0; i < contents.stations.size(); ++i) {
    if (!lines.contains(contents.line_of(contents.stations[i]).id)) continue;
    const Choice choice = choose(contents, i, frames, clock.uncertainty_s);
    if (choice.any == nullptr) {
      result.missing.push_back(i);
    } else if (choice.sharp == nullptr) {
      result.only_blurred.push_back(i);
    } else {
      const PlacedFrame& frame = *choice.sharp;
      result.found.push_back({i, frame.frame, frame.time_s, frame.position_mm});
      if (choice.any->blurred) ++result.blurred_skipped;
    }
  }
  std::sort(result.found.begin(), result.found.end(),
            [](const StationFrame& a, const StationFrame& b) { return a.frame < b.frame; });
  return result;
}

}  // namespace raywalk::capture
