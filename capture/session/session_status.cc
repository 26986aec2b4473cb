#include "capture/session/session_status.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include "capture/session/session_times.h"
#include "core/base/error.h"
#include "core/base/median.h"

namespace raywalk::capture {
namespace {

constexpr int kLastEvents = 5;
constexpr int kMostAttempts = 1000000000;
constexpr double kLongest_ms = 1e12;
constexpr double kUsPerSecond = 1e6;

std::vector<LineStatus> lines_of(const SessionContents& contents,
                                 const std::vector<FrameFault>& lost_frames) {
  std::set<std::string> lost;
  for (const FrameFault& fault : lost_frames) lost.insert(fault.station);
  std::vector<LineStatus> lines;
  for (const SessionLine& line : contents.lines) {
    lines.push_back({.id = line.id, .validation = line.validation});
  }
  for (const SessionStation& station : contents.stations) {
    LineStatus& line = lines[static_cast<std::size_t>(station.line)];
    ++line.stations;
    if (!station.shot) continue;
    if (station.shot->on_card) {
      ++line.exposed;
    } else if (lost.contains(station.name)) {
      ++line.lost;
    } else {
      ++line.captured;
    }
  }
  return lines;
}

void count_attempts(SessionReader* session, std::vector<LineStatus>* lines) {
  SqliteStatement row = session->query(
      "SELECT (SELECT count(*) FROM attempt JOIN station ON station.id = station_id "
      "WHERE station.line_id = line.id) AS attempts, "
      "EXISTS (SELECT 1 FROM journal WHERE journal.line_id = line.id) AS filmed "
      "FROM line ORDER BY line.id",
      "a line");
  for (LineStatus& line : *lines) {
    if (!row.step()) return;
    line.attempts = row.number(0, 0, kMostAttempts);
    line.filmed = row.boolean(1);
  }
}

std::map<std::string, int> faults_of(SessionReader* session) {
  SqliteStatement row =
      session->query("SELECT fault, count(*) FROM attempt WHERE outcome = 'failed' GROUP BY fault",
                     "a failed attempt");
  std::map<std::string, int> faults;
  while (row.step()) faults[row.text(0)] = row.number(1, 0, kMostAttempts);
  return faults;
}

// The values of a column of the captured attempts, without NULL.
std::vector<double> captured_values(SessionReader* session, const std::string& column) {
  SqliteStatement row = session->query(
      "SELECT " + column + " FROM attempt WHERE outcome IN ('captured', 'exposed') AND " + column +
          " IS NOT NULL",
      "an attempt");
  std::vector<double> values;
  while (row.step()) values.push_back(row.real(0, -kLongest_ms, kLongest_ms));
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

StationTimes times_of(SessionReader* session) {
  const std::vector<double> own_ms = captured_values(session, "own_ms");
  return {.moving_ms = median_of(captured_values(session, "moving_ms")),
          .settling_ms = median_of(captured_values(session, "settling_ms")),
          .exposing_ms = median_of(captured_values(session, "exposing_ms")),
          .transfer_ms = median_of(captured_values(session, "transfer_ms")),
          .own_ms = median_of(own_ms),
          .own_p95_ms = p95_of(own_ms)};
}

// The median time from one captured station of a line to the next; the median ignores breaks.
std::optional<double> pace_s(SessionReader* session) {
  SqliteStatement row = session->query(
      "SELECT station.line_id, ended_utc_us FROM attempt JOIN station ON station.id = station_id "
      "WHERE outcome IN ('captured', 'exposed') AND moving_ms IS NOT NULL ORDER BY attempt.id",
      "a captured attempt");
  std::vector<double> intervals_s;
  std::int64_t line = -1, ended_us = 0;
  while (row.step()) {
    const std::int64_t line_here = row.integer(0);
    const std::int64_t ended_here_us = row.utc_us(1);
    if (line_here == line) {
      intervals_s.push_back(static_cast<double>(ended_here_us - ended_us) / kUsPerSecond);
    }
    line = line_here;
    ended_us = ended_here_us;
  }
  return median_of(std::move(intervals_s));
}

std::vector<SessionEvent> last_events_of(SessionReader* session) {
  SqliteStatement row = session->query(
      "SELECT at_utc_us, kind, text FROM event ORDER BY id DESC LIMIT ?1", "an event");
  row.bind(kLastEvents);
  std::vector<SessionEvent> events;
  while (row.step()) {
    events.push_back({wall_time_from(row.utc_us(0)), row.text(1), one_line(row.text(2))});
  }
  std::reverse(events.begin(), events.end());
  return events;
}

std::string first_planned_station(const SessionContents& contents) {
  const auto first =
      std::find_if(contents.stations.begin(), contents.stations.end(),
                   [](const SessionStation& station) { return !station.shot.has_value(); });
  return first == contents.stations.end() ? "" : first->name;
}

std::string next_step_of(const SessionStatus& status, const SessionContents& contents) {
  const std::string& directory = status.directory;
  if (status.lost() > 0) {
    return "restore the missing frames from a copy, or give up their stations with raywalk-capture "
           "verify " +
           directory + " --give-up";
  }
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
         first_planned_station(contents);
}

int sum(const std::vector<LineStatus>& lines, int LineStatus::*count) {
  int total = 0;
  for (const LineStatus& line : lines) total += line.*count;
  return total;
}

}  // namespace

int SessionStatus::stations() const { return sum(lines, &LineStatus::stations); }
int SessionStatus::captured() const { return sum(lines, &LineStatus::captured); }
int SessionStatus::lost() const { return sum(lines, &LineStatus::lost); }
int SessionStatus::exposed() const { return sum(lines, &LineStatus::exposed); }

SessionStatus status_of(SessionReader* session) {
  const SessionContents contents = session->contents();
  SessionStatus status;
  status.directory = session->directory().string();
  status.mode = session->facts().mode;
  status.lost_frames = frame_faults(contents);
  status.lines = lines_of(contents, status.lost_frames);
  count_attempts(session, &status.lines);
  status.faults = faults_of(session);
  status.times = times_of(session);
  const int missing = status.stations() - status.captured() - status.exposed();
  if (const std::optional<double> pace = pace_s(session)) status.time_left_s = missing * *pace;
  status.last_events = last_events_of(session);
  status.next_step = next_step_of(status, contents);
  return status;
}

}  // namespace raywalk::capture
