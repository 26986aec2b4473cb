#include "capture/session/session_reader.h"

#include <array>
#include <utility>

#include "capture/session/session_database.h"
#include "core/files/json.h"
#include "core/session/session_file.h"

namespace raywalk::capture {
namespace {

// The enumerator that the database names.
template <typename Enum, std::size_t count>
Enum choice_of(const SqliteStatement& row, int column, const std::array<Enum, count>& choices) {
  const std::string word = row.name(column);
  std::string known;
  for (const Enum each : choices) {
    if (name_of(each) == word) return each;
    known += (known.empty() ? "" : " or ") + std::string(name_of(each));
  }
  row.fail(column, known);
}

}  // namespace

SessionReader::SessionReader(std::filesystem::path directory)
    : directory_(std::move(directory)), database_(open_session_to_read(directory_)) {}

SqliteStatement SessionReader::query(const std::string& sql, const std::string& row) {
  return {&database_, sql, row};
}

SessionFacts SessionReader::facts() {
  SqliteStatement row = query(
      "SELECT created_utc_us, mode, camera, frames, bracket_ev, locked_exposure, config_text "
      "FROM session",
      "the session");
  if (!row.step()) throw_damaged_session(directory_, "the table session has no row");
  SessionFacts facts{.created = wall_time_from(row.utc_us(0)),
                     .mode = choice_of(row, 1, kCaptureModes),
                     .camera = choice_of(row, 2, kCameraKinds),
                     .frames = choice_of(row, 3, kFrameKinds),
                     .bracket_ev = {},
                     .locked_exposure = row.text(5),
                     .config_text = row.text(6)};
  for (const CheckedJson& step : json(row.text(4), "bracket_ev").items()) {
    facts.bracket_ev.push_back(step.number());
  }
  if (facts.bracket_ev.empty()) row.fail(4, "an array of numbers");
  return facts;
}

std::optional<WholePlan> SessionReader::part_of() {
  const std::string text = database_.text("SELECT part_of FROM session");
  if (text.empty()) return std::nullopt;
  const CheckedJson whole = json(text, "part_of");
  return WholePlan{whole.at("lines").texts(), whole.at("sha256").text()};
}

CheckedJson SessionReader::json(const std::string& text, const std::string& column) const {
  return CheckedJson::parse(text,
                            session_database_path(directory_).string() + ": damaged: " + column,
                            "restore this file from a copy");
}

SessionContents SessionReader::contents() { return read_session_contents(&database_, directory_); }

std::vector<JournalSample> SessionReader::journal(const std::string& line) {
  SqliteStatement row = query(
      "SELECT at_utc_us, position_mm FROM journal JOIN line ON line.id = line_id "
      "WHERE line.name = ?1 ORDER BY journal.id",
      "the journal of line " + line);
  row.bind(line);
  std::vector<JournalSample> samples;
  while (row.step()) {
    samples.push_back({wall_time_from(row.utc_us(0)), row.real(1, -kFarthest_mm, kFarthest_mm)});
  }
  return samples;
}

CapturePlan plan_of(const SessionContents& contents) {
  CapturePlan plan;
  for (const SessionLine& line : contents.lines) {
    plan.lines.push_back({.id = line.id,
                          .axis = line.axis,
                          .across_m = line.across_m,
                          .validation = line.validation,
                          .stations = {}});
  }
  for (const SessionStation& station : contents.stations) {
    plan.lines[static_cast<std::size_t>(station.line)].stations.push_back(
        {station.name, station.planned_m, station.planned_mm});
  }
  return plan;
}

}  // namespace raywalk::capture
