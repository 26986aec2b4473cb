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
#include "capture/import/film_stations.h"
#include "capture/import/film_track.h"
#include "capture/import/import.h"
#include "capture/import/name_list.h"
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

void require_size(const FilmTrack& track, const SessionFacts& facts, const Session& session,
                  const fs::path& film) {
  const PanoramaSize size{track.size.width, track.size.height};
  if (facts.frames == FrameKind::kPanorama && size.width != 2 * size.height) {
    throw Error(
        fmt::format("{}: is {} x {} pixels, but a panorama is twice as wide as high; "
                    "stitch the film first",
                    film.string(), size.width, size.height));
  }
  const auto others = session.frame_size();
  if (others && *others != size) {
    throw Error(fmt::format("{}: is {} x {} pixels, but the session's frames are {} x {}",
                            film.string(), size.width, size.height, others->width, others->height));
  }
}

// The stations without a frame and why; empty if there are none.
std::string missing_frames(const FilmStations& film) {
  std::vector<std::string> parts;
  if (!film.missing.empty()) {
    parts.push_back(fmt::format("{} stations that the film does not show: {}", film.missing.size(),
                                name_list(film.missing)));
  }
  if (!film.only_blurred.empty()) {
    parts.push_back(fmt::format("{} stations with blurred frames only: {}",
                                film.only_blurred.size(), name_list(film.only_blurred)));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

WallTime journal_time(const SessionFacts& facts, double time_s) {
  return facts.created +
         std::chrono::duration_cast<WallTime::duration>(std::chrono::duration<double>(time_s));
}

Picture encode(const DecodedFrame& frame, const fs::path& film, const FilmImportOptions& options) {
  std::vector<unsigned char> bytes;
  std::vector<int> parameters;
  if (options.format == "jpg") parameters = {cv::IMWRITE_JPEG_QUALITY, kJpegQuality};
  cv::imencode("." + options.format, frame.picture, bytes, parameters);
  Picture picture;
  picture.bytes.assign(bytes.begin(), bytes.end());
  picture.extension = options.format;
  picture.camera_name = fmt::format("{} frame {}", film.filename().string(), frame.number);
  picture.size = {frame.picture.cols, frame.picture.rows};
  return picture;
}

// Reads the film again and stores the chosen frames; `chosen` is in order of frames.
void store_frames(Session* session, const fs::path& film, const FilmImportOptions& options,
                  const std::vector<StationFrame>& chosen,
                  const std::vector<SessionStation>& stations, const SessionFacts& facts) {
  Progress progress("Importing frames", static_cast<std::int64_t>(chosen.size()), "stations");
  auto next = chosen.begin();
  if (next == chosen.end()) return;
  read_film(film, [&](const DecodedFrame& frame) {
    if (frame.number != next->frame) return true;
    const Picture picture = encode(frame, film, options);
    if (next == chosen.begin()) require_frame_kind(picture.bytes, facts.frames, film.string());
    const SessionStation& station = stations[next->station];
    const AttemptId attempt = session->begin_attempt(station.name, station.planned_mm);
    const StoredFrame stored = session->store_frame(attempt, 0, picture);
    session->complete_from_film(attempt, next->position_mm, journal_time(facts, next->time_s),
                                {&stored, 1});
    progress.advance();
    return ++next != chosen.end();
  });
  if (next == chosen.end()) return;
  throw Error(fmt::format("{}: ended before frame {} on the second read; was it changed?",
                          film.string(), next->frame));
}

}  // namespace

ImportResult import_film(const fs::path& session_directory, const fs::path& film,
                         const FilmImportOptions& options, Clock* clock) {
  const std::unique_ptr<Session> session = Session::open(session_directory, clock);
  SessionReader reader(session_directory);
  const SessionFacts facts = reader.facts();
  const SessionContents contents = reader.contents();
  const std::vector<Travel> travels = read_travels(&reader, contents, options.line, facts.created);

  const FilmTrack track = track_film(film);
  require_size(track, facts, *session, film);
  const FilmClock film_clock = match_film_clock(track, travels, film.string());
  const FilmStations frames =
      find_station_frames(contents, track, travels, film_clock, film.string());
  const std::string account = missing_frames(frames);
  if (!account.empty() && !options.allow_missing) {
    throw Error(fmt::format("{}: {} (nothing was imported; --allow-missing imports the others)",
                            film.string(), account));
  }
  store_frames(session.get(), film, options, frames.found, contents.stations, facts);

  ImportResult result{.imported = frames.found.size(), .already_there = frames.captured_before};
  result.summary = fmt::format(
      "{} stations imported, {} had been before; the film starts at {} by the session's clock, "
      "within {:.3f} s or {:.2f} mm; frames are at most {:.2f} mm from their stations; blurred "
      "frames skipped: {}{}{}",
      result.imported, result.already_there,
      utc_text(utc_us_from(journal_time(facts, film_clock.offset_s))), film_clock.uncertainty_s,
      frames.uncertainty_mm, frames.farthest_mm, frames.blurred_skipped,
      account.empty() ? "" : "; ", account);
  session->record_event("film-imported", result.summary);
  return result;
}

}  // namespace raywalk::capture
