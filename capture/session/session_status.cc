#include "capture/session/session_status.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "capture/session/session_database.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/median.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr int kLastEvents = 5;
constexpr std::size_t kMostLostFrames = 8;  // listed in a text
constexpr int kMostAttempts = 1000000000;
constexpr double kLongest_ms = 1e12;
constexpr double kUsPerSecond = 1e6;

// Of every line: stations planned; captured, with frames in the session and on the disk; lost, of
// which a frame is missing or of another size; exposed, with pictures still on the camera's card.
Json lines_of(SessionReader* session, const SessionContents& contents,
              const std::vector<FrameFault>& lost_frames) {
  struct Counts {
    int stations = 0, captured = 0, lost = 0, exposed = 0;
  };
  std::set<std::string> lost;
  for (const FrameFault& fault : lost_frames) lost.insert(fault.station);
  std::vector<Counts> counts(contents.lines.size());
  for (const SessionStation& station : contents.stations) {
    Counts& line = counts[static_cast<std::size_t>(station.line)];
    ++line.stations;
    if (!station.shot) continue;
    ++(station.shot->on_card         ? line.exposed
       : lost.contains(station.name) ? line.lost
                                     : line.captured);
  }
  SqliteStatement row = session->query(
      "SELECT (SELECT count(*) FROM attempt JOIN station ON station.id = station_id "
      "WHERE station.line_id = line.id) AS attempts, "
      "EXISTS (SELECT 1 FROM journal WHERE journal.line_id = line.id) AS filmed "
      "FROM line ORDER BY line.id",
      "a line");
  Json lines = Json::array();
  for (std::size_t i = 0; i < contents.lines.size() && row.step(); ++i) {
    lines.push_back({{"id", contents.lines[i].id},
                     {"validation", contents.lines[i].validation},
                     {"stations", counts[i].stations},
                     {"captured", counts[i].captured},
                     {"exposed", counts[i].exposed},
                     {"lost", counts[i].lost},
                     {"attempts", row.number(0, 0, kMostAttempts)},
                     {"filmed", row.boolean(1)}});
  }
  return lines;
}

int sum(const Json& lines, const char* count) {
  int total = 0;
  for (const Json& line : lines) total += line[count].get<int>();
  return total;
}

Json faults_of(SessionReader* session) {
  SqliteStatement row =
      session->query("SELECT fault, count(*) FROM attempt WHERE outcome = 'failed' GROUP BY fault",
                     "a failed attempt");
  Json faults = Json::object();
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

Json median_of(std::vector<double> values) {
  return values.empty() ? Json() : Json(median(std::move(values)));
}

// The smallest value that at least 95 % of the values do not exceed (nearest rank).
Json p95_of(std::vector<double> values) {
  if (values.empty()) return {};
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(0.95 * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + rank - 1, values.end());
  return values[static_cast<std::size_t>(rank - 1)];
}

Json times_of(SessionReader* session) {
  Json times = Json::object();
  for (const std::string time :
       {"moving_ms", "settling_ms", "exposing_ms", "transfer_ms", "own_ms"}) {
    times[time] = median_of(captured_values(session, time));
  }
  times["own_p95_ms"] = p95_of(captured_values(session, "own_ms"));
  return times;
}

// The median time from one captured station of a line to the next; the median ignores breaks.
Json pace_s(SessionReader* session) {
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
  const std::string directory = status["directory"];
  if (status["lost"] > 0) {
    return "restore the missing frames from a copy, or give up their stations with raywalk-capture "
           "verify " +
           directory + " --give-up";
  }
  if (status["captured"] == status["stations"]) return "raywalk-capture export " + directory;
  if (mode == CaptureMode::kVideo) {
    const Json& lines = status["lines"];
    const auto line = std::find_if(lines.begin(), lines.end(),
                                   [](const Json& each) { return !each["filmed"].get<bool>(); });
    if (line == lines.end()) {
      return "raywalk-capture import " + directory + " --video FILE";
    }
    return "raywalk-capture run CONFIG --session " + directory + ", which films line " +
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

std::string duration_text(double seconds) {
  const auto minutes = static_cast<std::int64_t>(std::ceil(seconds / 60.0));
  return minutes < 60 ? fmt::format("{} min", minutes)
                      : fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string line_text(const Json& line) {
  const auto count = [&](const char* name) { return line[name].get<int>(); };
  std::string text = fmt::format("  {:<4} {:>6} of {} captured", line["id"].get<std::string>(),
                                 count("captured"), count("stations"));
  if (count("exposed") > 0) text += fmt::format(", {} on the camera's card", count("exposed"));
  if (count("lost") > 0) text += fmt::format(", {} lost", count("lost"));
  if (line["filmed"]) text += ", filmed";
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
    status[count] = sum(status["lines"], count);
  }
  status["lost_frames"] = Json::array();
  for (const FrameFault& fault : lost_frames) status["lost_frames"].push_back(fault.text);
  status["faults"] = faults_of(session);
  status["times"] = times_of(session);
  // At the pace so far, without placing the rail.
  const Json pace = pace_s(session);
  const int left = sum(status["lines"], "stations") - sum(status["lines"], "captured") -
                   sum(status["lines"], "exposed");
  status["time_left_s"] = pace.is_null() ? Json() : Json(left * pace.get<double>());
  status["last_events"] = last_events_of(session);
  status["next_step"] = next_step_of(status, contents, mode);
  return status;
}

std::string status_text(const Json& status) {
  const auto count = [&](const char* name) { return status[name].get<int>(); };
  std::string text =
      fmt::format("{}: {} of {} stations captured", escaped(status["directory"].get<std::string>()),
                  count("captured"), count("stations"));
  if (count("exposed") > 0) text += fmt::format(", {} on the camera's card", count("exposed"));
  if (count("lost") > 0) text += fmt::format(", {} lost", count("lost"));
  text += "\n";
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
