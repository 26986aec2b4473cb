#include "capture/import/import_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "capture/camera/check_picture.h"
#include "capture/import/card_pictures.h"
#include "capture/import/match_pictures.h"
#include "capture/session/frame_kind.h"
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

std::vector<ExposedStation> exposed_stations(SessionReader* reader, int exposures) {
  std::vector<ExposedStation> stations;
  SqliteStatement rows = reader->query(kExposedStations, "an exposed attempt");
  while (rows.step()) {
    ExposedStation station;
    station.attempt = {rows.integer(0, 1, INT64_MAX), rows.name(1), rows.number(2, 1, INT_MAX)};
    station.imported = rows.boolean(3);
    station.from = wall_time_from(rows.utc_us(4));
    station.to = station.from;
    if (exposures > 1) station.to = std::max(station.from, wall_time_from(rows.utc_us(5)));
    stations.push_back(std::move(station));
  }
  return stations;
}

std::vector<FailedAttempt> failed_attempts(SessionReader* reader) {
  std::vector<FailedAttempt> attempts;
  SqliteStatement rows = reader->query(kFailedAttempts, "a failed attempt");
  while (rows.step()) {
    attempts.push_back({wall_time_from(rows.utc_us(0)), wall_time_from(rows.utc_us(1))});
  }
  return attempts;
}

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
        "{}: this session was captured as video; import its film with --video", directory));
  }
  SessionShots shots;
  shots.exposures = facts.exposures();
  shots.stations = exposed_stations(reader, facts.exposures());
  shots.failed = failed_attempts(reader);
  if (shots.stations.empty()) {
    throw Error(
        fmt::format("{}: no station has been captured yet; run the session first", directory));
  }
  return shots;
}

Picture read_checked_picture(const fs::path& file, PanoramaSize size) {
  Picture picture;
  picture.bytes = read_file(file);
  const CheckedPicture checked = check_picture(picture.bytes, size, file.string());
  picture.extension = checked.extension;
  picture.size = checked.size;
  picture.camera_name = file.filename().string();
  return picture;
}

// Frames are named after their station: "x0_007.jpg", "x0_007_e1_front.jpg".
bool is_of_station(const fs::path& file, const std::string& station) {
  const std::string name = file.filename().string();
  return name.starts_with(station + ".") || name.starts_with(station + "_");
}

// The files in a session's frames/ that no row of its database names: of a killed import.
class UnnamedFrames {
 public:
  explicit UnnamedFrames(SessionReader* reader) : session_directory_(reader->directory()) {
    std::set<std::string> named;
    const SessionContents contents = reader->contents();
    for (const SessionFrame& frame : contents.frames) named.insert(frame.file);
    files_ = list_frames(session_directory_);
    std::erase_if(files_, [&](const std::string& file) {
      const fs::file_status status = fs::symlink_status(session_directory_ / file);
      return named.contains(file) || is_temporary_frame(file) || !fs::is_regular_file(status);
    });
  }

  // A file of this station with exactly these bytes, relative to the session's directory, to be
  // reused as its name is taken. It and its directory are synced on return. Throws Error if that
  // fails.
  std::optional<std::string> find(const std::string& station, const std::string& bytes) const {
    for (const std::string& file : files_) {
      const fs::path path = session_directory_ / file;
      if (!is_of_station(path, station) || read_file(path) != bytes) continue;
      // The file was synced before it was renamed; its directory may not have been.
      sync_directory(path.parent_path());
      return file;
    }
    return std::nullopt;
  }

 private:
  fs::path session_directory_;
  std::vector<std::string> files_;  // ascending
};

// Copies pictures station by station.
class PictureCopier {
 public:
  PictureCopier(Session* session, const CardPictures* card, UnnamedFrames stored_before)
      : session_(session),
        card_(card),
        stored_before_(std::move(stored_before)),
        size_(session->frame_size().value_or(PanoramaSize{})) {}

  // Stores all pictures of a station, then the rows that name them.
  void copy(const AttemptId& attempt, const std::vector<std::size_t>& shots) {
    std::vector<StoredFrame> frames;
    for (std::size_t exposure = 0; exposure < shots.size(); ++exposure) {
      for (const CardFile& file : card_->shots[shots[exposure]].files) {
        const Picture picture = read_checked_picture(file.file, size_);
        size_ = picture.size;  // the first sets it for all
        frames.push_back(store(attempt, static_cast<int>(exposure), picture, file.lens));
      }
    }
    session_->add_pictures(attempt, frames);
  }

 private:
  StoredFrame store(const AttemptId& attempt, int exposure, const Picture& picture,
                    FrameLens lens) {
    const auto before = stored_before_.find(attempt.station, picture.bytes);
    if (!before) return session_->store_frame(attempt, exposure, picture, lens);
    return {.file = *before,
            .bytes = static_cast<std::int64_t>(picture.bytes.size()),
            .sha256 = sha256_hex(std::as_bytes(std::span(picture.bytes))),
            .exposure_index = exposure,
            .lens = lens,
            .size = picture.size,
            .camera_name = picture.camera_name};
  }

  Session* session_;
  const CardPictures* card_;
  UnnamedFrames stored_before_;
  PanoramaSize size_;
};

// The checksums of the frames that each station has.
std::map<std::string, std::set<std::string>> checksums_by_station(SessionReader* reader) {
  std::map<std::string, std::set<std::string>> checksums;
  const SessionContents contents = reader->contents();
  for (const SessionFrame& frame : contents.frames) {
    checksums[contents.station_of(frame).name].insert(frame.sha256);
  }
  return checksums;
}

// A repeated import may bring the same pictures, but not different ones for the same station.
void require_same(const std::string& station, const std::set<std::string>& checksums,
                  const CardPictures& card, const std::vector<std::size_t>& shots) {
  for (const std::size_t shot : shots) {
    for (const CardFile& file : card.shots[shot].files) {
      const std::string bytes = read_file(file.file);
      if (checksums.contains(sha256_hex(bytes))) continue;
      throw Error(fmt::format(
          "{}: is assigned to {}, which already has a different picture; was the card changed, "
          "or is the picture of another session?",
          file.file.string(), station));
    }
  }
}

void require_complete(const PictureMatch& match, const SessionShots& shots,
                      const CardPictures& card) {
  if (is_complete(match, card)) return;
  throw Error(fmt::format("{} (nothing was imported; --allow-missing imports complete stations)",
                          describe_mismatches(match, shots, card)));
}

// The first new picture of every line shows what the session's frames are said to be. The files of
// a camera that writes one per lens are told by their names.
void look_at_pictures(const PictureMatch& match, const SessionShots& shots,
                      const CardPictures& card, FrameKind frames) {
  std::set<std::string> lines;
  for (const StationPictures& pictures : match.complete) {
    const ExposedStation& station = shots.stations[pictures.station];
    const std::string& name = station.attempt.station;
    const CardFile& file = card.shots[pictures.shots.front()].files.front();
    if (station.imported || file.lens != FrameLens::kBoth) continue;
    if (!lines.insert(name.substr(0, name.rfind('_'))).second) continue;
    require_frame_kind(read_file(file.file), frames, file.file.string());
  }
}

std::string summary_of(const PictureImport& result, const PictureMatch& match,
                       const SessionShots& shots, const CardPictures& card) {
  std::string summary = fmt::format("{} stations imported, {} had been before", result.imported,
                                    result.already_there);
  if (match.by_name) {
    summary += "; assigned by the names of the pictures";
  } else {
    summary += fmt::format(
        "; the camera's clock ({}) is off by {:+.1f} s, RMS residual {:.1f} s, drift {:+.0f} ppm",
        name_of(card.source), match.clock_offset_s, std::max(match.rms_s, 0.5 * card.resolution_s),
        1e6 * match.clock_drift);
  }
  if (!match.from_failed.empty()) {
    summary += fmt::format("; pictures of failed attempts left out: {}", match.from_failed.size());
  }
  if (!is_complete(match, card)) summary += "; " + describe_mismatches(match, shots, card);
  return summary;
}

}  // namespace

PictureImport import_pictures(const fs::path& session_directory,
                              std::span<const fs::path> files_and_directories, bool allow_missing,
                              Clock* clock, const std::string& first_station) {
  const std::unique_ptr<Session> session = Session::open(session_directory, clock);
  SessionReader reader(session_directory);
  const SessionShots shots = read_session_shots(&reader);
  const CardPictures card = read_card(files_and_directories);
  const PictureMatch match = first_station.empty() ? match_pictures(shots, card)
                                                   : assign_by_name(shots, card, first_station);
  if (!allow_missing) require_complete(match, shots, card);
  look_at_pictures(match, shots, card, reader.facts().frames);

  const auto checksums = checksums_by_station(&reader);
  PictureCopier copier(session.get(), &card, UnnamedFrames(&reader));
  Progress progress("Importing pictures", static_cast<std::int64_t>(match.complete.size()),
                    "stations");
  PictureImport result;
  for (const StationPictures& pictures : match.complete) {
    throw_if_interrupted();
    const ExposedStation& station = shots.stations[pictures.station];
    if (station.imported) {
      require_same(station.attempt.station, checksums.at(station.attempt.station), card,
                   pictures.shots);
      ++result.already_there;
    } else {
      copier.copy(station.attempt, pictures.shots);
      ++result.imported;
    }
    progress.advance();
  }
  result.summary = summary_of(result, match, shots, card);
  session->record_event("pictures-imported", result.summary);
  return result;
}

}  // namespace raywalk::capture
