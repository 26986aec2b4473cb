#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/camera/check_picture.h"
#include "capture/import/import.h"
#include "capture/import/name_list.h"
#include "capture/import/video_stations.h"
#include "capture/import/video_track.h"
#include "capture/session/session.h"
#include "capture/session/session_database.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 95;

// All passes of the selected lines.
std::vector<Travel> read_travels(SessionReader* reader, const SessionContents& contents,
                                 const std::string& only_line, WallTime start) {
  std::vector<std::string> lines;
  for (const SessionLine& line : contents.lines) lines.push_back(line.id);
  if (!only_line.empty() && std::find(lines.begin(), lines.end(), only_line) == lines.end()) {
    throw UsageError(fmt::format("{} has no line {}; its lines are {}",
                                 reader->directory().string(), only_line, fmt::join(lines, ", ")));
  }
  std::vector<Travel> travels;
  for (const std::string& line : lines) {
    if (!only_line.empty() && line != only_line) continue;
    for (Travel& travel : travels_of(line, reader->journal(line), start)) {
      travels.push_back(std::move(travel));
    }
  }
  if (travels.empty()) {
    throw Error(fmt::format(
        "{}: no journal of {}, so the carriage's positions are unknown; run the session with "
        "run.mode: video, or capture it station by station",
        reader->directory().string(), only_line.empty() ? "any line" : "line " + only_line));
  }
  return travels;
}

void require_size(const VideoTrack& track, const SessionFacts& facts, const Session& session,
                  const fs::path& video) {
  const PanoramaSize size{track.size.width, track.size.height};
  if (facts.frames == FrameKind::kPanorama && size.width != 2 * size.height) {
    throw Error(
        fmt::format("{}: is {} x {} pixels, but a panorama is twice as wide as high; "
                    "stitch the video first",
                    video.string(), size.width, size.height));
  }
  const auto others = session.frame_size();
  if (others && *others != size) {
    throw Error(fmt::format("{}: is {} x {} pixels, but the session's frames are {} x {}",
                            video.string(), size.width, size.height, others->width,
                            others->height));
  }
}

// The stations without a frame and why; empty if there are none.
std::string missing_frames(const VideoStations& video) {
  std::vector<std::string> parts;
  if (!video.missing.empty()) {
    parts.push_back(fmt::format("{} stations that the video does not show: {}",
                                video.missing.size(), name_list(video.missing)));
  }
  if (!video.only_blurred.empty()) {
    parts.push_back(fmt::format("{} stations with blurred frames only: {}",
                                video.only_blurred.size(), name_list(video.only_blurred)));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

WallTime journal_time(const SessionFacts& facts, double time_s) {
  return facts.created +
         std::chrono::duration_cast<WallTime::duration>(std::chrono::duration<double>(time_s));
}

Picture encode(const DecodedFrame& frame, const fs::path& video,
               const VideoImportOptions& options) {
  std::vector<unsigned char> bytes;
  std::vector<int> parameters;
  if (options.format == "jpg") parameters = {cv::IMWRITE_JPEG_QUALITY, kJpegQuality};
  cv::imencode("." + options.format, frame.picture, bytes, parameters);
  Picture picture;
  picture.bytes.assign(bytes.begin(), bytes.end());
  picture.extension = options.format;
  picture.camera_name = fmt::format("{} frame {}", video.filename().string(), frame.number);
  picture.size = {frame.picture.cols, frame.picture.rows};
  return picture;
}

// Reads the video again and stores the chosen frames; `chosen` is in order of frames.
void store_frames(Session* session, const fs::path& video, const VideoImportOptions& options,
                  const std::vector<StationFrame>& chosen,
                  const std::vector<SessionStation>& stations, const SessionFacts& facts) {
  Progress progress("Importing frames", static_cast<std::int64_t>(chosen.size()), "stations");
  auto next = chosen.begin();
  if (next == chosen.end()) return;
  read_video(video, [&](const DecodedFrame& frame) {
    if (frame.number != next->frame) return true;
    const Picture picture = encode(frame, video, options);
    if (next == chosen.begin()) require_frame_kind(picture.bytes, facts.frames, video.string());
    const SessionStation& station = stations[next->station];
    const AttemptId attempt = session->begin_attempt(station.name, station.planned_mm);
    const StoredFrame stored = session->store_frame(attempt, 0, picture);
    session->complete_from_video(attempt, next->position_mm, journal_time(facts, next->time_s),
                                 {&stored, 1});
    progress.advance();
    return ++next != chosen.end();
  });
  if (next == chosen.end()) return;
  throw Error(fmt::format("{}: ended before frame {} on the second read; was it changed?",
                          video.string(), next->frame));
}

}  // namespace

ImportResult import_video(const fs::path& session_directory, const fs::path& video,
                          const VideoImportOptions& options, Clock* clock) {
  const std::unique_ptr<Session> session = Session::open(session_directory, clock);
  SessionReader reader(session_directory);
  const SessionFacts facts = reader.facts();
  const SessionContents contents = reader.contents();
  const std::vector<Travel> travels = read_travels(&reader, contents, options.line, facts.created);

  const VideoTrack track = track_video(video);
  require_size(track, facts, *session, video);
  const VideoClock video_clock = match_video_clock(track, travels, video.string());
  const VideoStations frames =
      find_station_frames(contents, track, travels, video_clock, video.string());
  const std::string account = missing_frames(frames);
  if (!account.empty() && !options.allow_missing) {
    throw Error(fmt::format("{}: {} (nothing was imported; --allow-missing imports the others)",
                            video.string(), account));
  }
  store_frames(session.get(), video, options, frames.found, contents.stations, facts);

  ImportResult result{.imported = frames.found.size(), .already_there = frames.captured_before};
  result.summary = fmt::format(
      "{} stations imported, {} had been before; the video starts at {} by the session's clock, "
      "within {:.3f} s or {:.2f} mm; frames are at most {:.2f} mm from their stations; blurred "
      "frames skipped: {}{}{}",
      result.imported, result.already_there,
      utc_text(utc_us_from(journal_time(facts, video_clock.offset_s))), video_clock.uncertainty_s,
      frames.uncertainty_mm, frames.farthest_mm, frames.blurred_skipped,
      account.empty() ? "" : "; ", account);
  session->record_event("video-imported", result.summary);
  return result;
}

}  // namespace raywalk::capture
