// SessionStatus as text and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/session/session_status.h"
#include "capture/session/session_times.h"
#include "core/base/escaped.h"

namespace raywalk::capture {
namespace {

constexpr std::size_t kMostLostFrames = 8;  // listed

std::string duration_text(double seconds) {
  const auto minutes = static_cast<std::int64_t>(std::ceil(seconds / 60.0));
  return minutes < 60 ? fmt::format("{} min", minutes)
                      : fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string line_text(const LineStatus& line) {
  std::string text =
      fmt::format("  {:<4} {:>6} of {} captured", line.id, line.captured, line.stations);
  if (line.exposed > 0) text += fmt::format(", {} on the camera's card", line.exposed);
  if (line.lost > 0) text += fmt::format(", {} lost", line.lost);
  if (line.filmed) text += ", filmed";
  const int more = line.attempts - line.captured - line.exposed - line.lost;
  if (more > 0) text += fmt::format(", {} further attempts", more);
  return text + (line.validation ? "  (validation)\n" : "\n");
}

std::string time_text(const std::string& name, const std::optional<double>& ms) {
  return ms ? fmt::format("{} {:.0f} ms, ", name, *ms) : "";
}

std::string times_text(const StationTimes& times) {
  std::string text =
      time_text("moving", times.moving_ms) + time_text("settling", times.settling_ms) +
      time_text("exposing", times.exposing_ms) + time_text("transfer", times.transfer_ms);
  if (times.own_ms) {
    text += fmt::format("the program itself {:.1f} ms (95 % within {:.1f} ms)", *times.own_ms,
                        *times.own_p95_ms);
  }
  return text.empty() ? "" : "median station: " + text + "\n";
}

std::string lost_text(const std::vector<FrameFault>& lost_frames) {
  std::string text;
  const std::size_t shown = std::min(lost_frames.size(), kMostLostFrames);
  for (std::size_t i = 0; i < shown; ++i) text += "lost: " + lost_frames[i].text + "\n";
  if (lost_frames.size() > shown) {
    text += fmt::format("lost: and {} more\n", lost_frames.size() - shown);
  }
  return text;
}

std::string faults_text(const std::map<std::string, int>& faults) {
  std::string text;
  for (const auto& [fault, count] : faults) {
    text += fmt::format("{}{} {}", text.empty() ? "failed attempts: " : ", ", fault, count);
  }
  return text.empty() ? "" : text + "\n";
}

std::string events_text(const std::vector<SessionEvent>& events) {
  std::string text = events.empty() ? "" : "last events:\n";
  for (const SessionEvent& event : events) {
    text += fmt::format("  {}  {}{}{}\n", utc_text(utc_us_from(event.at)), event.kind,
                        event.text.empty() ? "" : ": ", event.text);
  }
  return text;
}

nlohmann::json json_of(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

}  // namespace

std::string status_text(const SessionStatus& status) {
  std::string text = fmt::format("{}: {} of {} stations captured", escaped(status.directory),
                                 status.captured(), status.stations());
  if (status.exposed() > 0) text += fmt::format(", {} on the camera's card", status.exposed());
  if (status.lost() > 0) text += fmt::format(", {} lost", status.lost());
  text += "\n";
  for (const LineStatus& line : status.lines) text += line_text(line);
  text += lost_text(status.lost_frames) + faults_text(status.faults) + times_text(status.times);
  if (status.time_left_s && *status.time_left_s > 0.0) {
    text += fmt::format("time left: about {}, without placing the rail\n",
                        duration_text(*status.time_left_s));
  }
  return text + events_text(status.last_events) + "next: " + status.next_step + "\n";
}

nlohmann::json status_json(const SessionStatus& status) {
  nlohmann::json lines = nlohmann::json::array(), events = nlohmann::json::array(),
                 lost_frames = nlohmann::json::array();
  for (const FrameFault& fault : status.lost_frames) lost_frames.push_back(fault.text);
  for (const LineStatus& line : status.lines) {
    lines.push_back({{"id", line.id},
                     {"validation", line.validation},
                     {"stations", line.stations},
                     {"captured", line.captured},
                     {"exposed", line.exposed},
                     {"lost", line.lost},
                     {"attempts", line.attempts},
                     {"filmed", line.filmed}});
  }
  for (const SessionEvent& event : status.last_events) {
    events.push_back(
        {{"at_utc_us", utc_us_from(event.at)}, {"kind", event.kind}, {"text", event.text}});
  }
  const StationTimes& times = status.times;
  return {{"directory", status.directory},
          {"mode", name_of(status.mode)},
          {"stations", status.stations()},
          {"captured", status.captured()},
          {"exposed", status.exposed()},
          {"lost", status.lost()},
          {"lost_frames", lost_frames},
          {"lines", lines},
          {"faults", status.faults},
          {"times",
           {{"moving_ms", json_of(times.moving_ms)},
            {"settling_ms", json_of(times.settling_ms)},
            {"exposing_ms", json_of(times.exposing_ms)},
            {"transfer_ms", json_of(times.transfer_ms)},
            {"own_ms", json_of(times.own_ms)},
            {"own_p95_ms", json_of(times.own_p95_ms)}}},
          {"time_left_s", json_of(status.time_left_s)},
          {"last_events", events},
          {"next_step", status.next_step}};
}

}  // namespace raywalk::capture
