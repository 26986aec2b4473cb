#include "core/session/session_contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/session/session_file.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr int kMostAttempts = 1000000;
constexpr std::int64_t kLargestFile_bytes = std::int64_t{1} << 50;
constexpr double kFarthest_m = kFarthest_mm / 1000.0;
// The largest slider.motion.settle_tolerance_mm.
constexpr double kLargestTolerance_mm = 100.0;

// The index of a row of the database in a vector of SessionContents.
using Indices = std::map<std::int64_t, int>;

void read_session_row(SqliteConnection* database, SessionContents* contents) {
  SqliteStatement row(database,
                      "SELECT frames, json_array_length(bracket_ev) AS bracket_ev FROM session",
                      "the session");
  if (!row.step()) throw_damaged_session(contents->directory, "the table session has no row");
  contents->frame_kind = row.name(0);
  contents->exposures = row.number(1, 1, kMostExposures);
}

// The place of a row that another one refers to in `column`.
int index_of(const Indices& indices, const SqliteStatement& row, int column) {
  const auto found = indices.find(row.integer(column));
  if (found == indices.end()) row.fail(column, "a row of the session");
  return found->second;
}

Indices read_lines(SqliteConnection* database, SessionContents* contents) {
  SqliteStatement row(database, "SELECT id, name, axis, across_m, validation FROM line ORDER BY id",
                      "a line");
  Indices indices;
  while (row.step()) {
    const std::string id = row.name(1);
    row.call("line " + id);
    indices[row.integer(0)] = static_cast<int>(contents->lines.size());
    contents->lines.push_back({.id = id,
                               .axis = row.choice(2, std::array{LineAxis::kX, LineAxis::kZ}),
                               .across_m = row.real(3, -kFarthest_m, kFarthest_m),
                               .validation = row.boolean(4)});
  }
  return indices;
}

// Columns of the query for stations, from `first` on.
SessionShot read_shot(const SqliteStatement& row, int first) {
  const std::string outcome = row.name(first + 2);
  return {.attempt = row.integer(first, 1, INT64_MAX),
          .number = row.number(first + 1, 1, kMostAttempts),
          .on_card = outcome == "exposed",
          .measured_mm = row.real(first + 3, -kFarthest_mm, kFarthest_mm),
          .triggered_utc_us = row.optional_utc_us(first + 4),
          .exposed_utc_us = row.optional_utc_us(first + 5)};
}

Indices read_stations(SqliteConnection* database, const Indices& lines, SessionContents* contents) {
  SqliteStatement row(
      database,
      "SELECT station.id, name, line_id, x_m, z_m, planned_mm, attempt.id, attempt.number, "
      "outcome, measured_mm, triggered_utc_us, exposed_utc_us "
      "FROM station LEFT JOIN attempt ON attempt.station_id = station.id "
      "AND outcome IN ('captured', 'exposed') ORDER BY line_id, station.number",
      "a station");
  constexpr int kFirstOfAttempt = 6;
  Indices indices;
  while (row.step()) {
    SessionStation station{.name = row.name(1)};
    row.call("station " + station.name);
    indices[row.integer(0)] = static_cast<int>(contents->stations.size());
    station.line = index_of(lines, row, 2);
    station.planned_m = {row.real(3, -kFarthest_m, kFarthest_m),
                         row.real(4, -kFarthest_m, kFarthest_m)};
    station.planned_mm = row.real(5, -kFarthest_mm, kFarthest_mm);
    if (!row.is_null(kFirstOfAttempt)) station.shot = read_shot(row, kFirstOfAttempt);
    contents->stations.push_back(std::move(station));
  }
  return indices;
}

// How far the feedback may be from the planned position: to the nearest neighbour on the line, or
// the largest tolerance of a slider.
double reach_mm(const SessionContents& contents, std::size_t index) {
  const SessionStation& station = contents.stations[index];
  double nearest_mm = HUGE_VAL;
  for (const std::size_t other : {index - 1, index + 1}) {
    if (other >= contents.stations.size()) continue;
    const SessionStation& neighbour = contents.stations[other];
    if (neighbour.line != station.line) continue;
    nearest_mm = std::min(nearest_mm, std::abs(neighbour.planned_mm - station.planned_mm));
  }
  return std::max(nearest_mm, kLargestTolerance_mm);
}

void require_shots_at_their_stations(const SessionContents& contents) {
  for (std::size_t i = 0; i < contents.stations.size(); ++i) {
    const SessionStation& station = contents.stations[i];
    if (!station.shot) continue;
    const double off_mm = station.shot->measured_mm - station.planned_mm;
    if (std::abs(off_mm) <= reach_mm(contents, i)) continue;
    throw_damaged_session(
        contents.directory,
        fmt::format("measured_mm of station {} is {:.6g}, but the station is planned at {:.6g} mm",
                    station.name, station.shot->measured_mm, station.planned_mm));
  }
}

PlanPoint position_of(const SessionStation& station, LineAxis axis) {
  PlanPoint position = station.planned_m;
  const double off_m = (station.shot->measured_mm - station.planned_mm) / 1000.0;
  (axis == LineAxis::kX ? position.x_m : position.z_m) += off_m;
  return position;
}

// A session only writes names within its directory; any other may be an attack.
std::string file_within(const SqliteStatement& row, int column, const fs::path& directory) {
  const fs::path path(row.name(column));
  bool inside = path.is_relative();
  for (const fs::path& part : path) inside = inside && part != "..";
  if (inside) return path.string();
  throw Error(fmt::format("{}: names the frame {}, which is not in its directory",
                          session_database_path(directory).string(), excerpt(path.string())));
}

// Those of failed attempts are left out.
void read_frames(SqliteConnection* database, const Indices& stations, SessionContents* contents) {
  SqliteStatement row(database,
                      "SELECT file, bytes, sha256, exposure, lens, station_id FROM frame "
                      "JOIN attempt ON attempt.id = attempt_id AND outcome = 'captured' "
                      "JOIN station ON station.id = station_id "
                      "ORDER BY line_id, station.number, exposure, lens",
                      "a frame");
  while (row.step()) {
    SessionFrame frame{.file = file_within(row, 0, contents->directory)};
    row.call("frame " + frame.file);
    frame.bytes = row.integer(1, 1, kLargestFile_bytes);
    frame.sha256 = row.name(2);
    frame.exposure = row.number(3, 0, contents->exposures - 1);
    frame.lens = row.choice(4, kFrameLenses);
    frame.station = index_of(stations, row, 5);
    const SessionStation& station = contents->station_of(frame);
    frame.position_m = position_of(station, contents->line_of(station).axis);
    contents->frames.push_back(std::move(frame));
  }
}

}  // namespace

SessionContents read_session_contents(SqliteConnection* database, const fs::path& directory) {
  const SqliteTransaction snapshot(database, SqliteTransaction::Kind::kRead);
  SessionContents contents;
  contents.directory = directory;
  read_session_row(database, &contents);
  const Indices lines = read_lines(database, &contents);
  const Indices stations = read_stations(database, lines, &contents);
  require_shots_at_their_stations(contents);
  read_frames(database, stations, &contents);
  return contents;
}

std::string file_fault(const SessionContents& contents, const SessionFrame& frame) {
  const fs::path file = contents.directory / frame.file;
  const auto fault = [&](const std::string& what) {
    return fmt::format("{} (station {}): {}", frame.file, contents.station_of(frame).name, what);
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) return fault(error.message());
  if (!fs::is_regular_file(status)) return fault("not a regular file");
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) return fault(error.message());
  if (bytes != static_cast<std::uintmax_t>(frame.bytes)) {
    return fault(fmt::format("{} bytes, {} were written", bytes, frame.bytes));
  }
  return "";
}

std::vector<FrameFault> incomplete_stations(const SessionContents& contents) {
  // As the session's first frame is: one file for both lenses, or two.
  const bool one_file = contents.frames.empty() || contents.frames.front().lens == FrameLens::kBoth;
  std::map<std::pair<int, int>, int> files;  // of a station and an exposure
  for (const SessionFrame& frame : contents.frames) ++files[{frame.station, frame.exposure}];
  std::vector<FrameFault> faults;
  for (std::size_t i = 0; i < contents.stations.size(); ++i) {
    const SessionStation& station = contents.stations[i];
    if (!station.shot || station.shot->on_card) continue;
    for (int exposure = 0; exposure < contents.exposures; ++exposure) {
      const int found = files[{static_cast<int>(i), exposure}];
      if (found == (one_file ? 1 : 2)) continue;
      faults.push_back(
          {station.name,
           found == 0
               ? fmt::format("station {}: has no frame of exposure {}", station.name, exposure)
               : fmt::format("station {}: exposure {} lacks the picture of a lens", station.name,
                             exposure)});
      break;
    }
  }
  return faults;
}

std::vector<FrameFault> frame_faults(const SessionContents& contents) {
  std::vector<FrameFault> faults = incomplete_stations(contents);
  for (const SessionFrame& frame : contents.frames) {
    std::string fault = file_fault(contents, frame);
    if (!fault.empty()) faults.push_back({contents.station_of(frame).name, std::move(fault)});
  }
  return faults;
}

void require_no_faults(const std::vector<FrameFault>& faults, const fs::path& directory) {
  if (faults.empty()) return;
  const std::string more =
      faults.size() > 1 ? fmt::format(" (and {} more faults)", faults.size() - 1) : "";
  throw Error(one_line(
      fmt::format("{0}: {1}{2}; restore the frames from a copy, or give up their stations with "
                  "'raywalk-capture verify {0} --give-up', so that they can be captured again",
                  directory.string(), faults.front().text, more)));
}

}  // namespace raywalk
