#include "capture/session/session_status.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "capture/plan/capture_time.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr int kLastEvents = 5;
constexpr std::size_t kMostLostFrames = 8;  // listed in a text
constexpr int kMostAttempts = 1000000000;
constexpr double kLongest_ms = 1e12;
constexpr double kUsPerSecond = 1e6;
constexpr std::array kTimes = {"moving_ms", "settling_ms", "exposing_ms", "transfer_ms", "own_ms"};

// Counts of every line: stations planned; captured, with frames in the session and on the disk;
// exposed, with pictures still on the card; lost, of which a frame is missing or of another size.
Json lines_of(SessionReader* session, const SessionContents& contents,
              const std::vector<FrameFault>& lost_frames) {
  std::set<std::string> lost_stations;
  for (const FrameFault& fault : lost_frames) lost_stations.insert(fault.station);
  std::vector<int> lost(contents.lines.size());
  for (const SessionStation& station : contents.stations) {
    if (lost_stations.contains(station.name)) ++lost[static_cast<std::size_t>(station.line)];
  }
  SqliteStatement row = session->query(
      "SELECT line.name, validation, count(DISTINCT station.id), count(attempt.id), "
      "count(*) FILTER (WHERE outcome = 'captured'), count(*) FILTER (WHERE outcome = 'exposed'), "
      "EXISTS (SELECT 1 FROM journal WHERE journal.line_id = line.id) "
      "FROM line JOIN station ON station.line_id = line.id "
      "LEFT JOIN attempt ON station_id = station.id GROUP BY line.id",
      "a line");
  Json lines = Json::array();
  for (std::size_t i = 0; i < lost.size() && row.step(); ++i) {
    lines.push_back({{"id", row.name(0)},
                     {"validation", row.boolean(1)},
                     {"stations", row.number(2, 0, kMostAttempts)},
                     {"captured", row.number(4, 0, kMostAttempts) - lost[i]},
                     {"exposed", row.number(5, 0, kMostAttempts)},
                     {"lost", lost[i]},
                     {"attempts", row.number(3, 0, kMostAttempts)},
                     {"recorded", row.boolean(6)}});
  }
  return lines;
}

Json faults_of(SessionReader* session) {
  SqliteStatement row =
      session->query("SELECT fault, count(*) FROM attempt WHERE outcome = 'failed' GROUP BY fault",
                     "a failed attempt");
  Json faults = Json::object();
  while (row.step()) faults[row.text(0)] = row.number(1, 0, kMostAttempts);
  return faults;
}

// The smallest value that at least this fraction of the values do not exceed (nearest rank); null
// where there are none.
Json quantile(double fraction, std::vector<double> values) {
  if (values.empty()) return {};
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(fraction * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + rank - 1, values.end());
  return values[static_cast<std::size_t>(rank - 1)];
}

// "times" of the captured stations, and "time_left_s" of those left at the pace so far: the median
// time from one captured station of a line to the next, which ignores breaks. Without placing the
// rail.
void add_times(SessionReader* session, Json* status) {
  SqliteStatement row =
      session->query(fmt::format("SELECT {}, ended_utc_us, line_id FROM attempt "
                                 "JOIN station ON station.id = station_id "
                                 "WHERE outcome IN ('captured', 'exposed') ORDER BY attempt.id",
                                 fmt::join(kTimes, ", ")),
                     "a captured attempt");
  constexpr int kEnded = kTimes.size(), kLine = kEnded + 1;  // columns behind the times
  std::array<std::vector<double>, kTimes.size()> times_ms;
  std::vector<double> intervals_s;
  std::int64_t line = -1, ended_us = 0;
  while (row.step()) {
    for (std::size_t i = 0; i < kTimes.size(); ++i) {
      const auto column = static_cast<int>(i);
      if (row.is_null(column)) continue;
      times_ms[i].push_back(row.real(column, -kLongest_ms, kLongest_ms));
    }
    if (row.is_null(0)) continue;  // a frame of a video
    if (row.integer(kLine) == line) {
      intervals_s.push_back(static_cast<double>(row.utc_us(kEnded) - ended_us) / kUsPerSecond);
    }
    line = row.integer(kLine);
    ended_us = row.utc_us(kEnded);
  }
  Json& times = (*status)["times"];
  for (std::size_t i = 0; i < kTimes.size(); ++i) times[kTimes[i]] = quantile(0.5, times_ms[i]);
  times["own_p95_ms"] = quantile(0.95, times_ms.back());
  const Json pace_s = quantile(0.5, std::move(intervals_s));
  const auto count = [&](const char* name) { return (*status)[name].get<int>(); };
  const int left = count("stations") - count("captured") - count("exposed");
  (*status)["time_left_s"] = pace_s.is_null() ? Json() : Json(left * pace_s.get<double>());
}

// Oldest first.
Json last_events_of(SessionReader* session) {
  SqliteStatement row = session->query(
      "SELECT at_utc_us, kind, text FROM event ORDER BY id DESC LIMIT ?1", "an event");
  row.bind(kLastEvents);
  Json events = Json::array();
  while (row.step()) {
    const Json event = {
        {"at_utc_us", row.utc_us(0)}, {"kind", row.text(1)}, {"text", one_line(row.text(2))}};
    events.insert(events.begin(), event);
  }
  return events;
}

std::string next_step_of(const Json& status, const SessionContents& contents, CaptureMode mode) {
  const std::string directory = escaped(status["directory"].get<std::string>());
  if (status["lost"] > 0) {
    return "restore the missing frames from a copy, or give up their stations with raywalk-capture "
           "verify " +
           directory + " --give-up";
  }
  if (status["captured"] == status["stations"]) return "raywalk-capture export " + directory;
  if (mode == CaptureMode::kVideo) {
    const Json& lines = status["lines"];
    const auto line = std::find_if(lines.begin(), lines.end(),
                                   [](const Json& each) { return !each["recorded"].get<bool>(); });
    if (line == lines.end()) {
      return "raywalk-capture import " + directory + " --video FILE";
    }
    return "raywalk-capture run CONFIG --session " + directory + ", which records line " +
           (*line)["id"].get<std::string>();
  }
  const auto planned = std::ranges::find_if(
      contents.stations, [](const SessionStation& station) { return !station.shot; });
  if (planned == contents.stations.end()) {
    return "raywalk-capture import " + directory + " FILES (the pictures on the camera's card)";
  }
  return "raywalk-capture run CONFIG --session " + directory + ", which resumes at station " +
         planned->name;
}

// Of a line or the session: "", or ", 3 on the camera's card, 2 lost".
std::string elsewhere_text(const Json& counts) {
  std::string text;
  if (counts["exposed"] > 0) {
    text += fmt::format(", {} on the camera's card", counts["exposed"].get<int>());
  }
  if (counts["lost"] > 0) text += fmt::format(", {} lost", counts["lost"].get<int>());
  return text;
}

std::string line_text(const Json& line) {
  const auto count = [&](const char* name) { return line[name].get<int>(); };
  std::string text = fmt::format("  {:<4} {:>6} of {} captured{}", line["id"].get<std::string>(),
                                 count("captured"), count("stations"), elsewhere_text(line));
  if (line["recorded"]) text += ", recorded";
  const int more = count("attempts") - count("captured") - count("exposed") - count("lost");
  if (more > 0) text += fmt::format(", {} further attempts", more);
  return text + (line["validation"] ? "  (validation)\n" : "\n");
}

std::string times_text(const Json& times) {
  std::string text;
  for (const std::string name : {"moving", "settling", "exposing", "transfer"}) {
    const Json& ms = times[name + "_ms"];
    if (!ms.is_null()) text += fmt::format("{} {:.0f} ms, ", name, ms.get<double>());
  }
  if (!times["own_ms"].is_null()) {
    text += fmt::format("the program itself {:.1f} ms (95 % within {:.1f} ms)",
                        times["own_ms"].get<double>(), times["own_p95_ms"].get<double>());
  }
  return text.empty() ? "" : "median station: " + text + "\n";
}

std::string lost_text(const Json& lost_frames) {
  std::string text;
  const std::size_t shown = std::min(lost_frames.size(), kMostLostFrames);
  for (std::size_t i = 0; i < shown; ++i) {
    text += "lost: " + lost_frames[i].get<std::string>() + "\n";
  }
  if (lost_frames.size() > shown) {
    text += fmt::format("lost: and {} more\n", lost_frames.size() - shown);
  }
  return text;
}

std::string faults_text(const Json& faults) {
  std::string text;
  for (const auto& [fault, count] : faults.items()) {
    text +=
        fmt::format("{}{} {}", text.empty() ? "failed attempts: " : ", ", fault, count.get<int>());
  }
  return text.empty() ? "" : text + "\n";
}

std::string events_text(const Json& events) {
  std::string text = events.empty() ? "" : "last events:\n";
  for (const Json& event : events) {
    const std::string said = event["text"];
    text += fmt::format("  {}  {}{}{}\n", utc_text(event["at_utc_us"].get<std::int64_t>()),
                        event["kind"].get<std::string>(), said.empty() ? "" : ": ", said);
  }
  return text;
}

}  // namespace

Json session_status(SessionReader* session) {
  const SessionContents contents = session->contents();
  const CaptureMode mode = session->facts().mode;
  const std::vector<FrameFault> lost_frames = frame_faults(contents);
  Json status;
  status["directory"] = session->directory().string();
  status["mode"] = name_of(mode);
  status["lines"] = lines_of(session, contents, lost_frames);
  for (const char* count : {"stations", "captured", "exposed", "lost"}) {
    int sum = 0;
    for (const Json& line : status["lines"]) sum += line[count].get<int>();
    status[count] = sum;
  }
  status["lost_frames"] = Json::array();
  for (const FrameFault& fault : lost_frames) status["lost_frames"].push_back(fault.text);
  status["faults"] = faults_of(session);
  add_times(session, &status);
  status["last_events"] = last_events_of(session);
  status["next_step"] = next_step_of(status, contents, mode);
  return status;
}

std::string status_text(const Json& status) {
  std::string text = fmt::format(
      "{}: {} of {} stations captured{}\n", escaped(status["directory"].get<std::string>()),
      status["captured"].get<int>(), status["stations"].get<int>(), elsewhere_text(status));
  for (const Json& line : status["lines"]) text += line_text(line);
  text += lost_text(status["lost_frames"]) + faults_text(status["faults"]) +
          times_text(status["times"]);
  const Json& left_s = status["time_left_s"];
  if (!left_s.is_null() && left_s > 0.0) {
    text += fmt::format("time left: about {}, without placing the rail\n",
                        duration_text(left_s.get<double>()));
  }
  return text + events_text(status["last_events"]) +
         "next: " + status["next_step"].get<std::string>() + "\n";
}

}  // namespace raywalk::capture
