#include "core/session/session_contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/session/session_file.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr int kMostStations = 1000000;
constexpr int kMostAttempts = 1000000;
constexpr int kLargestSide_px = 1 << 20;
constexpr std::int64_t kLargestFile_bytes = std::int64_t{1} << 50;
constexpr double kFarthest_m = kFarthest_mm / 1000.0;
// The index of a row of the database in a vector of SessionContents.
using Indices = std::map<std::int64_t, int>;

void read_session_row(SqliteConnection* database, SessionContents* contents) {
  SessionRow row(database,
                 "SELECT frames, json_array_length(bracket_ev) AS bracket_ev FROM session",
                 contents->directory, "the session");
  if (!row.step()) throw_damaged_session(contents->directory, "the table session has no row");
  contents->frame_kind = row.name(0);
  contents->exposures = row.number(1, 1, kMostExposures);
}

LineAxis axis_of(const SessionRow& row, int column) {
  const std::string axis = row.name(column);
  if (axis == "x") return LineAxis::kX;
  if (axis != "z") row.fail(column, "x or z");
  return LineAxis::kZ;
}

Indices read_lines(SqliteConnection* database, SessionContents* contents) {
  SessionRow row(database, "SELECT id, name, axis, across_m, validation FROM line ORDER BY id",
                 contents->directory, "a line");
  Indices indices;
  while (row.step()) {
    const std::string id = row.name(1);
    row.call("line " + id);
    indices[row.integer(0, INT64_MIN, INT64_MAX)] = static_cast<int>(contents->lines.size());
    contents->lines.push_back({.id = id,
                               .axis = axis_of(row, 2),
                               .across_m = row.real(3, -kFarthest_m, kFarthest_m),
                               .validation = row.boolean(4)});
  }
  return indices;
}

// Columns of the query for stations, from `first` on.
SessionShot read_shot(const SessionRow& row, int first) {
  const std::string outcome = row.name(first + 2);
  return {.attempt = row.integer(first, 1, INT64_MAX),
          .number = row.number(first + 1, 1, kMostAttempts),
          .on_card = outcome == "exposed",
          .measured_mm = row.real(first + 3, -kFarthest_mm, kFarthest_mm),
          .triggered_utc_us = row.optional_utc_us(first + 4),
          .exposed_utc_us = row.optional_utc_us(first + 5)};
}

void read_stations(SqliteConnection* database, const Indices& lines, SessionContents* contents) {
  SessionRow row(
      database,
      "SELECT station.name, station.line_id, station.number, x_m, z_m, planned_mm, attempt.id, "
      "attempt.number, outcome, measured_mm, triggered_utc_us, exposed_utc_us "
      "FROM station LEFT JOIN attempt ON attempt.station_id = station.id "
      "AND outcome IN ('captured', 'exposed') ORDER BY station.line_id, station.number",
      contents->directory, "a station");
  constexpr int kFirstOfAttempt = 6;
  while (row.step()) {
    SessionStation station{.name = row.name(0)};
    row.call("station " + station.name);
    const auto line = lines.find(row.integer(1, INT64_MIN, INT64_MAX));
    if (line == lines.end()) row.fail(1, "a line of the session");
    station.line = line->second;
    row.number(2, 0, kMostStations);
    station.planned_m = {row.real(3, -kFarthest_m, kFarthest_m),
                         row.real(4, -kFarthest_m, kFarthest_m)};
    station.planned_mm = row.real(5, -kFarthest_mm, kFarthest_mm);
    if (!row.is_null(kFirstOfAttempt)) station.shot = read_shot(row, kFirstOfAttempt);
    contents->stations.push_back(std::move(station));
  }
}

PlanPoint position_of(const SessionStation& station, LineAxis axis) {
  PlanPoint position = station.planned_m;
  const double off_m = (station.shot->measured_mm - station.planned_mm) / 1000.0;
  (axis == LineAxis::kX ? position.x_m : position.z_m) += off_m;
  return position;
}

// A session only writes names within its directory; any other may be an attack.
std::string file_within(const SessionRow& row, int column, const fs::path& directory) {
  const fs::path path(row.name(column));
  bool inside = path.is_relative();
  for (const fs::path& part : path) inside = inside && part != "..";
  if (inside) return path.string();
  throw Error(fmt::format("{}: names the frame {}, which is not in its directory",
                          session_database_path(directory).string(), excerpt(path.string())));
}

FrameLens lens_of(const SessionRow& row, int column) {
  const std::string word = row.name(column);
  const auto lens = std::find_if(kFrameLenses.begin(), kFrameLenses.end(),
                                 [&](FrameLens each) { return name_of(each) == word; });
  if (lens == kFrameLenses.end()) row.fail(column, "both, front or back");
  return *lens;
}

SessionFrame read_frame(SessionRow& row, const SessionContents& contents) {
  const std::string file = file_within(row, 0, contents.directory);
  row.call("frame " + file);
  row.number(3, 1, kLargestSide_px);
  row.number(4, 1, kLargestSide_px);
  return {.file = file,
          .bytes = row.integer(1, 1, kLargestFile_bytes),
          .sha256 = row.name(2),
          .exposure = row.number(5, 0, contents.exposures - 1),
          .lens = lens_of(row, 6)};
}

// Every row is checked; the frames of failed attempts are not kept.
void read_frames(SqliteConnection* database, SessionContents* contents) {
  Indices station_of_attempt;
  for (std::size_t i = 0; i < contents->stations.size(); ++i) {
    const auto& shot = contents->stations[i].shot;
    if (shot && !shot->on_card) station_of_attempt[shot->attempt] = static_cast<int>(i);
  }
  SessionRow row(
      database,
      "SELECT file, bytes, sha256, width_px, height_px, exposure, lens, attempt_id FROM frame",
      contents->directory, "a frame");
  while (row.step()) {
    SessionFrame frame = read_frame(row, *contents);
    const auto found = station_of_attempt.find(row.integer(7, INT64_MIN, INT64_MAX));
    if (found == station_of_attempt.end()) continue;
    frame.station = found->second;
    const SessionStation& station = contents->station_of(frame);
    frame.position_m = position_of(station, contents->line_of(station).axis);
    contents->frames.push_back(std::move(frame));
  }
  std::sort(contents->frames.begin(), contents->frames.end(),
            [](const SessionFrame& a, const SessionFrame& b) {
              return std::tuple(a.station, a.exposure, name_of(a.lens)) <
                     std::tuple(b.station, b.exposure, name_of(b.lens));
            });
}

}  // namespace

SessionContents read_session_contents(SqliteConnection* database, const fs::path& directory) {
  const SqliteTransaction snapshot(database, SqliteTransaction::Kind::kRead);
  SessionContents contents;
  contents.directory = directory;
  read_session_row(database, &contents);
  const Indices lines = read_lines(database, &contents);
  read_stations(database, lines, &contents);
  read_frames(database, &contents);
  return contents;
}

}  // namespace raywalk
