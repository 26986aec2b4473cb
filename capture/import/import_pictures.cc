#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "capture/camera/check_picture.h"
#include "capture/import/card_pictures.h"
#include "capture/import/import.h"
#include "capture/import/match_pictures.h"
#include "capture/session/session.h"
#include "capture/session/session_database.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// The camera starts to expose at exposed_utc_us. The times of the single exposures of a bracket are
// not recorded; they lie between then and the end of exposing.
constexpr char kExposedStations[] =
    "SELECT attempt.id, station.name, attempt.number, attempt.outcome = 'captured',"
    " coalesce(attempt.exposed_utc_us, attempt.triggered_utc_us) AS exposed_utc_us,"
    " coalesce(attempt.triggered_utc_us, attempt.exposed_utc_us)"
    " + cast(coalesce(attempt.exposing_ms, 0) * 1000 AS INTEGER) AS end_of_exposing_utc_us "
    "FROM attempt JOIN station ON station.id = attempt.station_id "
    "WHERE attempt.outcome IN ('exposed', 'captured')"
    " AND coalesce(attempt.exposed_utc_us, attempt.triggered_utc_us) IS NOT NULL "
    "ORDER BY 5, attempt.id";

// An attempt interrupted by a crash has no end time; its pictures were taken before the next one
// began.
constexpr char kFailedAttempts[] =
    "SELECT begun_utc_us, coalesce(ended_utc_us, (SELECT min(next.begun_utc_us) FROM attempt AS "
    "next WHERE next.id > attempt.id), begun_utc_us + 60000000)"
    " AS ended_utc_us "
    "FROM attempt WHERE outcome = 'failed' OR outcome IS NULL ORDER BY begun_utc_us";

// Every station whose pictures were taken, and every failed attempt that may have left pictures on
// the card, both in order of time. Throws Error if the camera does not keep its pictures on a card,
// the session was captured as video, or no picture was taken.
SessionShots read_session_shots(SessionReader* reader) {
  const SessionFacts facts = reader->facts();
  const std::string directory = reader->directory().string();
  if (facts.camera != CameraKind::kGpio) {
    throw UsageError(fmt::format(
        "{}: the {} camera sent its pictures during the run; there is nothing to import from a "
        "card",
        directory, name_of(facts.camera)));
  }
  if (facts.mode == CaptureMode::kVideo) {
    throw UsageError(fmt::format(
        "{}: this session was captured as video; import its video with --video", directory));
  }
  SessionShots shots{.exposures = facts.exposures()};
  SqliteStatement exposed = reader->query(kExposedStations, "an exposed attempt");
  while (exposed.step()) {
    const AttemptId attempt{exposed.integer(0, 1, INT64_MAX), exposed.name(1),
                            exposed.number(2, 1, INT_MAX)};
    const WallTime from = wall_time_from(exposed.utc_us(4));
    const WallTime to = shots.exposures == 1 ? from : wall_time_from(exposed.utc_us(5));
    shots.stations.push_back({attempt, from, std::max(from, to), exposed.boolean(3)});
  }
  SqliteStatement failed = reader->query(kFailedAttempts, "a failed attempt");
  while (failed.step()) {
    shots.failed.push_back({wall_time_from(failed.utc_us(0)), wall_time_from(failed.utc_us(1))});
  }
  if (shots.stations.empty()) {
    throw Error(
        fmt::format("{}: no station has been captured yet; run the session first", directory));
  }
  return shots;
}

// Frames are named after their station: "x0_007.jpg", "x0_007_e1_front.jpg".
bool is_of_station(const fs::path& file, const std::string& station) {
  const std::string name = file.filename().string();
  return name.starts_with(station + ".") || name.starts_with(station + "_");
}

// Copies pictures station by station.
class PictureCopier {
 public:
  PictureCopier(Session* session, const CardPictures* card)
      : session_(session),
        card_(card),
        files_(list_frames(session->directory())),
        size_(session->frame_size().value_or(PanoramaSize{})) {}

  // Stores all pictures of a station, then the rows that name them.
  void copy(const AttemptId& attempt, const std::vector<std::size_t>& shots) {
    std::vector<StoredFrame> frames;
    for (std::size_t exposure = 0; exposure < shots.size(); ++exposure) {
      for (const CardFile& file : card_->shots[shots[exposure]]) {
        frames.push_back(store(attempt, static_cast<int>(exposure), file));
      }
    }
    session_->add_pictures(attempt, frames);
  }

 private:
  StoredFrame store(const AttemptId& attempt, int exposure, const CardFile& file) {
    Picture picture;
    picture.bytes = read_file(file.file);
    const CheckedPicture checked = check_picture(picture.bytes, size_, file.file.string());
    size_ = checked.size;  // the first sets it for all
    picture.extension = checked.extension;
    picture.size = checked.size;
    picture.camera_name = file.file.filename().string();
    const std::string before = stored_before(attempt.station, picture.bytes);
    if (before.empty()) return session_->store_frame(attempt, exposure, picture, file.lens);
    return {.file = before,
            .bytes = static_cast<std::int64_t>(picture.bytes.size()),
            .sha256 = sha256_hex(std::as_bytes(std::span(picture.bytes))),
            .exposure_index = exposure,
            .lens = file.lens,
            .size = picture.size,
            .camera_name = picture.camera_name};
  }

  // A file of this station with exactly these bytes, of a killed import: no row names the files of
  // a station without pictures. It is reused as its name is taken. It and its directory are synced
  // on return. Throws Error if that fails.
  std::string stored_before(const std::string& station, const std::string& bytes) const {
    for (const std::string& file : files_) {
      const fs::path path = session_->directory() / file;
      const bool is_file = fs::is_regular_file(fs::symlink_status(path));
      if (!is_file || !is_of_station(path, station) || read_file(path) != bytes) continue;
      // The file was synced before it was renamed; its directory may not have been.
      sync_directory(path.parent_path());
      return file;
    }
    return "";
  }

  Session* session_;
  const CardPictures* card_;
  std::vector<std::string> files_;  // of the session before the import
  PanoramaSize size_;
};

// A repeated import may bring the same pictures, but not different ones for the same station.
void require_same(const std::string& station, const SessionContents& contents,
                  const CardPictures& card, const std::vector<std::size_t>& shots) {
  for (const std::size_t shot : shots) {
    for (const CardFile& file : card.shots[shot]) {
      const std::string sha256 = sha256_hex(read_file(file.file));
      const auto is_same = [&](const SessionFrame& frame) {
        return frame.sha256 == sha256 && contents.station_of(frame).name == station;
      };
      if (std::ranges::any_of(contents.frames, is_same)) continue;
      throw Error(fmt::format(
          "{}: is assigned to {}, which already has a different picture; was the card changed, "
          "or is the picture of another session?",
          file.file.string(), station));
    }
  }
}

// The first new picture of every line shows what the session's frames are said to be. The files of
// a camera that writes one per lens are told by their names.
void look_at_pictures(const PictureMatch& match, const SessionShots& shots,
                      const CardPictures& card, FrameKind frames) {
  std::set<std::string> lines;
  for (const StationPictures& pictures : match.complete) {
    const ExposedStation& station = shots.stations[pictures.station];
    const std::string& name = station.attempt.station;
    const CardFile& file = card.shots[pictures.shots.front()].front();
    if (station.imported || file.lens != FrameLens::kBoth) continue;
    if (!lines.insert(name.substr(0, name.rfind('_'))).second) continue;
    require_frame_kind(read_file(file.file), frames, file.file.string());
  }
}

std::string summary_of(const ImportResult& result, const PictureMatch& match,
                       const CardPictures& card) {
  std::string summary = fmt::format("{} stations imported, {} had been before", result.imported,
                                    result.already_there);
  if (match.clock) {
    summary += fmt::format(
        "; the camera's clock ({}) is off by {:+.1f} s, RMS residual {:.1f} s, drift {:+.0f} ppm",
        card.time_source, match.clock->offset_s,
        std::max(match.clock->rms_s, 0.5 * card.resolution_s), 1e6 * match.clock->drift);
  } else {
    summary += "; assigned by the names of the pictures";
  }
  if (match.from_failed > 0) {
    summary += fmt::format("; pictures of failed attempts left out: {}", match.from_failed);
  }
  if (!match.mismatches.empty()) summary += "; " + match.mismatches;
  return summary;
}

}  // namespace

ImportResult import_pictures(const fs::path& session_directory,
                             std::span<const fs::path> files_and_directories, bool allow_missing,
                             Clock* clock, const std::string& first_station) {
  const std::unique_ptr<Session> session = Session::open(session_directory, clock);
  SessionReader reader(session_directory);
  const SessionShots shots = read_session_shots(&reader);
  const CardPictures card = read_card(files_and_directories);
  const PictureMatch match = first_station.empty() ? match_pictures(shots, card)
                                                   : assign_by_name(shots, card, first_station);
  if (!match.mismatches.empty() && !allow_missing) {
    throw Error(fmt::format("{} (nothing was imported; --allow-missing imports complete stations)",
                            match.mismatches));
  }
  look_at_pictures(match, shots, card, reader.facts().frames);

  const SessionContents contents = reader.contents();
  PictureCopier copier(session.get(), &card);
  Progress progress("Importing pictures", static_cast<std::int64_t>(match.complete.size()),
                    "stations");
  ImportResult result;
  for (const StationPictures& pictures : match.complete) {
    throw_if_interrupted();
    const ExposedStation& station = shots.stations[pictures.station];
    if (station.imported) {
      require_same(station.attempt.station, contents, card, pictures.shots);
      ++result.already_there;
    } else {
      copier.copy(station.attempt, pictures.shots);
      ++result.imported;
    }
    progress.advance();
  }
  result.summary = summary_of(result, match, card);
  session->record_event("pictures-imported", result.summary);
  return result;
}

}  // namespace raywalk::capture
