#include "capture/session/session_status.h"

#include <algorithm>
#include <cmath>

#include "capture/session/session_times.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

constexpr int kLastEvents = 5;
constexpr double kUsPerSecond = 1e6;

std::vector<LineStatus> lines_of(SqliteConnection* database) {
  SqliteStatement row(
      database,
      "SELECT line.name, line.validation, count(DISTINCT station.id), "
      "count(CASE outcome WHEN 'captured' THEN 1 END), "
      "count(CASE outcome WHEN 'exposed' THEN 1 END), count(attempt.id), "
      "EXISTS (SELECT 1 FROM journal WHERE journal.line_id = line.id) FROM line "
      "JOIN station ON station.line_id = line.id "
      "LEFT JOIN attempt ON attempt.station_id = station.id GROUP BY line.id ORDER BY line.id");
  std::vector<LineStatus> lines;
  while (row.step()) {
    lines.push_back({.id = row.text(0),
                     .validation = row.integer(1) != 0,
                     .stations = static_cast<int>(row.integer(2)),
                     .captured = static_cast<int>(row.integer(3)),
                     .exposed = static_cast<int>(row.integer(4)),
                     .attempts = static_cast<int>(row.integer(5)),
                     .filmed = row.integer(6) != 0});
  }
  return lines;
}

std::map<std::string, int> faults_of(SqliteConnection* database) {
  SqliteStatement row(
      database, "SELECT fault, count(*) FROM attempt WHERE outcome = 'failed' GROUP BY fault");
  std::map<std::string, int> faults;
  while (row.step()) faults[row.text(0)] = static_cast<int>(row.integer(1));
  return faults;
}

// The values of a column of the captured attempts, without NULL.
std::vector<double> captured_values(SqliteConnection* database, const std::string& column) {
  SqliteStatement row(database, "SELECT " + column +
                                    " FROM attempt WHERE outcome IN ('captured', 'exposed') AND " +
                                    column + " IS NOT NULL");
  std::vector<double> values;
  while (row.step()) values.push_back(row.real(0));
  return values;
}

std::optional<double> median_of(std::vector<double> values) {
  return values.empty() ? std::nullopt : std::optional(median(std::move(values)));
}

// The smallest value that at least 95 % of the values do not exceed (nearest rank).
std::optional<double> p95_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(0.95 * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + rank - 1, values.end());
  return values[static_cast<std::size_t>(rank - 1)];
}

StationTimes times_of(SqliteConnection* database) {
  const std::vector<double> own_ms = captured_values(database, "own_ms");
  return {.moving_ms = median_of(captured_values(database, "moving_ms")),
          .settling_ms = median_of(captured_values(database, "settling_ms")),
          .exposing_ms = median_of(captured_values(database, "exposing_ms")),
          .transfer_ms = median_of(captured_values(database, "transfer_ms")),
          .own_ms = median_of(own_ms),
          .own_p95_ms = p95_of(own_ms)};
}

// The median time from one captured station of a line to the next; the median ignores breaks.
std::optional<double> pace_s(SqliteConnection* database) {
  SqliteStatement row(
      database,
      "SELECT station.line_id, ended_utc_us FROM attempt JOIN station ON station.id = station_id "
      "WHERE outcome IN ('captured', 'exposed') AND moving_ms IS NOT NULL ORDER BY attempt.id");
  std::vector<double> intervals_s;
  std::int64_t line = -1, ended_us = 0;
  while (row.step()) {
    if (row.integer(0) == line) {
      intervals_s.push_back(static_cast<double>(row.integer(1) - ended_us) / kUsPerSecond);
    }
    line = row.integer(0);
    ended_us = row.integer(1);
  }
  return median_of(std::move(intervals_s));
}

std::vector<SessionEvent> last_events_of(SqliteConnection* database) {
  SqliteStatement row(database,
                      "SELECT at_utc_us, kind, text FROM event ORDER BY id DESC LIMIT ?1");
  row.bind(kLastEvents);
  std::vector<SessionEvent> events;
  while (row.step()) events.push_back({wall_time_from(row.integer(0)), row.text(1), row.text(2)});
  std::reverse(events.begin(), events.end());
  return events;
}

std::string first_planned_station(SqliteConnection* database) {
  return database->text(
      "SELECT station.name FROM station WHERE NOT EXISTS (SELECT 1 FROM attempt WHERE station_id = "
      "station.id AND outcome IN ('captured', 'exposed')) ORDER BY line_id, number LIMIT 1");
}

std::string next_step_of(const SessionStatus& status, SqliteConnection* database) {
  const std::string& directory = status.directory;
  if (status.captured() == status.stations()) return "raywalk-capture export " + directory;
  if (status.mode == CaptureMode::kVideo) {
    const auto line = std::find_if(status.lines.begin(), status.lines.end(),
                                   [](const LineStatus& each) { return !each.filmed; });
    if (line == status.lines.end()) return "raywalk-capture import " + directory + " --video FILE";
    return "raywalk-capture run CONFIG --session " + directory + ", which films line " + line->id;
  }
  if (status.captured() + status.exposed() == status.stations()) {
    return "raywalk-capture import " + directory + " FILES (the pictures on the camera's card)";
  }
  return "raywalk-capture run CONFIG --session " + directory + ", which resumes at station " +
         first_planned_station(database);
}

int sum(const std::vector<LineStatus>& lines, int LineStatus::*count) {
  int total = 0;
  for (const LineStatus& line : lines) total += line.*count;
  return total;
}

}  // namespace

int SessionStatus::stations() const { return sum(lines, &LineStatus::stations); }
int SessionStatus::captured() const { return sum(lines, &LineStatus::captured); }
int SessionStatus::exposed() const { return sum(lines, &LineStatus::exposed); }

SessionStatus status_of(SessionReader* session) {
  SqliteConnection* database = &session->database();
  SessionStatus status;
  status.directory = session->directory().string();
  status.mode = session->facts().mode;
  status.lines = lines_of(database);
  status.faults = faults_of(database);
  status.times = times_of(database);
  const int missing = status.stations() - status.captured() - status.exposed();
  if (const std::optional<double> pace = pace_s(database)) status.time_left_s = missing * *pace;
  status.last_events = last_events_of(database);
  status.next_step = next_step_of(status, database);
  return status;
}

}  // namespace raywalk::capture
