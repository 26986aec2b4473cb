// Finds the frame of a video for each station: the journal of the slider's feedback says where the
// carriage was, and the starts and stops that the video shows compare its clock with the journal's.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/import/video_track.h"
#include "capture/session/session.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

// One uninterrupted pass over a line, of at least two samples in ascending time; seconds since any
// epoch. The position is interpolated linearly between samples. The carriage is assumed to be at
// rest for kRest_s before the first and after the last sample.
struct Travel {
  static constexpr double kRest_s = 1.5;

  std::string line{};
  std::vector<double> times_s{};
  std::vector<double> positions_mm{};

  double begin_s() const { return times_s.front() - kRest_s; }
  double end_s() const { return times_s.back() + kRest_s; }
  std::optional<double> position_mm(double time_s) const;  // empty before and after the rest
  double speed_mm_s(double from_s, double to_s) const;     // mean, absolute
};

// Splits the journal of a line into passes, at gaps of more than a second. Samples that are not
// later than the one before are dropped. Times are in seconds since `start`.
std::vector<Travel> travels_of(const std::string& line, std::span<const JournalSample> journal,
                               WallTime start);

struct VideoClock {
  double offset_s = 0.0;       // journal time minus video time
  double uncertainty_s = 0.0;  // half of what starts and stops disagree by, and half a frame
};

// Finds the offset at which the starts and stops that a video shows are successive ones of the
// carriage: the mean of those by the first and the last. A video of steady motion alone is
// rejected. `video` names the video in errors.
//
// A start is where the activity of frames, or the speed in the journal, passes a quarter of that in
// steady motion for good; both are averaged over the same time, so that the delay cancels.
//
// Throws Error if the video shows no motion, or its starts and stops fit the journal at no time or
// at several.
VideoClock match_video_clock(const VideoTrack& track, std::span<const Travel> travels,
                             const std::string& video);

struct StationFrame {
  std::size_t station = 0;   // index into SessionContents::stations
  std::size_t frame = 0;     // index into VideoTrack::frames
  double time_s = 0.0;       // of the journal
  double position_mm = 0.0;  // of the frame, on the rail
};

struct VideoStations {
  std::vector<StationFrame> found{};        // in order of frames
  std::vector<std::string> missing{};       // stations of the recorded lines without any frame
  std::vector<std::string> only_blurred{};  // stations with blurred frames only
  std::size_t captured_before = 0;          // stations of the recorded lines that have a picture
  std::size_t blurred_skipped = 0;          // stations whose nearest frame was blurred
  double farthest_mm = 0.0;                 // of a frame from its station
  double uncertainty_mm = 0.0;              // by that of the clock, of the fastest frame found
};

// For each station of the recorded lines that has no picture yet, the sharp frame with the least
// position error: the minimum of |position - planned| + speed * clock uncertainty. Frames farther
// than half the distance to the next station do not count. Throws Error, naming the video, if the
// clock is too uncertain to tell stations apart.
VideoStations find_station_frames(const SessionContents& contents, const VideoTrack& track,
                                  std::span<const Travel> travels, const VideoClock& clock,
                                  const std::string& video);

}  // namespace raywalk::capture
