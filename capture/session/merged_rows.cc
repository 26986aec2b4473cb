#include "capture/session/merged_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "capture/session/session_database.h"
#include "capture/session/session_times.h"
#include "core/base/number_text.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// The row of an attempt, and where it comes from.
struct AttemptRow {
  std::size_t part = 0;
  std::int64_t id = 0;  // in that session
  std::string station{};
  std::int64_t number = 0;
  std::string outcome{};
  std::int64_t begun_utc_us = 0;
  std::optional<std::int64_t> ended_utc_us{};
  double commanded_mm = 0.0;
  std::optional<double> measured_mm{};
  std::optional<double> moving_ms{};
  std::optional<double> settling_ms{};
  std::optional<std::int64_t> triggered_utc_us{};
  std::optional<std::int64_t> exposed_utc_us{};
  std::optional<double> exposing_ms{};
  std::optional<double> transfer_ms{};
  std::optional<double> own_ms{};
  std::optional<std::string> fault{};
  std::optional<std::string> message{};
};

std::optional<std::string> optional_text(const SqliteStatement& row, int column) {
  return row.is_null(column) ? std::nullopt : std::optional(row.text(column));
}

// An attempt that a killed run left open is none.
void read_attempts(SessionReader* session, const MergedLine& line, std::vector<AttemptRow>* rows) {
  SqliteStatement row(
      &session->database(),
      "SELECT attempt.id, station.name, attempt.number, outcome, begun_utc_us, ended_utc_us, "
      "commanded_mm, measured_mm, moving_ms, settling_ms, triggered_utc_us, exposed_utc_us, "
      "exposing_ms, transfer_ms, own_ms, fault, message FROM attempt "
      "JOIN station ON station.id = station_id JOIN line ON line.id = line_id "
      "WHERE line.name = ?1 AND outcome IS NOT NULL ORDER BY attempt.id");
  row.bind(line.id);
  while (row.step()) {
    rows->push_back({.part = line.part,
                     .id = row.integer(0),
                     .station = row.text(1),
                     .number = row.integer(2),
                     .outcome = row.text(3),
                     .begun_utc_us = row.integer(4),
                     .ended_utc_us = row.optional_integer(5),
                     .commanded_mm = row.real(6),
                     .measured_mm = row.optional_real(7),
                     .moving_ms = row.optional_real(8),
                     .settling_ms = row.optional_real(9),
                     .triggered_utc_us = row.optional_integer(10),
                     .exposed_utc_us = row.optional_integer(11),
                     .exposing_ms = row.optional_real(12),
                     .transfer_ms = row.optional_real(13),
                     .own_ms = row.optional_real(14),
                     .fault = optional_text(row, 15),
                     .message = optional_text(row, 16)});
  }
}

class MergedDatabase {
 public:
  MergedDatabase(SqliteConnection* database,
                 std::span<const std::unique_ptr<SessionReader>> readers,
                 const std::vector<SessionPart>& parts, const std::vector<MergedLine>& lines)
      : database_(database), readers_(readers), parts_(parts), lines_(lines) {}

  void write(const CapturePlan& plan, std::int64_t now_utc_us) {
    create_session(database_, facts(), plan);
    add_attempts();
    add_frames();
    add_journals();
    add_events(now_utc_us);
  }

 private:
  SqliteConnection* database_of(std::size_t part) { return &readers_[part]->database(); }

  SessionFacts facts() const {
    const MergedLine& last = *std::ranges::max_element(
        lines_, {}, [](const MergedLine& line) { return line.captured.ended_utc_us; });
    SessionFacts facts = parts_[last.part].facts;
    facts.created = std::ranges::min_element(parts_, {}, [](const SessionPart& part) {
                      return part.facts.created;
                    })->facts.created;
    return facts;
  }

  // In the order of time, as one session would have them.
  void add_attempts() {
    std::map<std::string, std::int64_t> station_row;
    SqliteStatement station(database_, "SELECT name, id FROM station");
    while (station.step()) station_row[station.text(0)] = station.integer(1);
    std::vector<AttemptRow> rows;
    for (const MergedLine& line : lines_) read_attempts(readers_[line.part].get(), line, &rows);
    std::ranges::stable_sort(rows, {}, &AttemptRow::begun_utc_us);
    SqliteStatement add(
        database_,
        "INSERT INTO attempt (station_id, number, outcome, begun_utc_us, ended_utc_us, "
        "commanded_mm, measured_mm, moving_ms, settling_ms, triggered_utc_us, exposed_utc_us, "
        "exposing_ms, transfer_ms, own_ms, fault, message) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, "
        "?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16)");
    for (const AttemptRow& row : rows) {
      add.bind(station_row.at(row.station), row.number, row.outcome, row.begun_utc_us,
               row.ended_utc_us, row.commanded_mm, row.measured_mm, row.moving_ms, row.settling_ms,
               row.triggered_utc_us, row.exposed_utc_us, row.exposing_ms, row.transfer_ms,
               row.own_ms, row.fault, row.message)
          .run();
      attempt_row_[{row.part, row.id}] = database_->last_row();
    }
  }

  void add_frames() {
    SqliteStatement add(database_,
                        "INSERT INTO frame (attempt_id, exposure, lens, file, bytes, sha256, "
                        "width_px, height_px, camera_name, settings) "
                        "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)");
    for (const MergedLine& line : lines_) {
      SqliteStatement row(
          database_of(line.part),
          "SELECT attempt_id, exposure, lens, file, bytes, sha256, width_px, height_px, "
          "camera_name, settings FROM frame JOIN attempt ON attempt.id = attempt_id "
          "JOIN station ON station.id = station_id JOIN line ON line.id = line_id "
          "WHERE line.name = ?1 ORDER BY frame.id");
      row.bind(line.id);
      while (row.step()) {
        add.bind(attempt_row_.at({line.part, row.integer(0)}), row.integer(1), row.text(2),
                 row.text(3), row.integer(4), row.text(5), row.integer(6), row.integer(7),
                 row.text(8), row.text(9))
            .run();
      }
    }
  }

  void add_journals() {
    SqliteStatement add(database_,
                        "INSERT INTO journal (line_id, at_utc_us, position_mm) "
                        "SELECT id, ?2, ?3 FROM line WHERE name = ?1");
    for (const MergedLine& line : lines_) {
      for (const JournalSample& sample : readers_[line.part]->journal(line.id)) {
        add.bind(line.id, utc_us_from(sample.time), sample.position_mm).run();
      }
    }
  }

  void add_events(std::int64_t now_utc_us) {
    struct Event {
      std::int64_t at_utc_us;
      std::string kind;
      std::string text;
    };
    std::vector<Event> events;
    for (std::size_t part = 0; part < parts_.size(); ++part) {
      SqliteStatement row(database_of(part), "SELECT at_utc_us, kind, text FROM event ORDER BY id");
      while (row.step()) {
        events.push_back({row.integer(0), row.text(1), parts_[part].name + ": " + row.text(2)});
      }
    }
    std::ranges::stable_sort(events, {}, &Event::at_utc_us);
    for (const MergedLine& line : lines_) {
      std::string text =
          fmt::format("{}: {} of {}", line.id, counted(line.captured.captured, "station"),
                      parts_[line.part].directory.string());
      for (const std::size_t replaced : line.replaced) {
        text += ", in place of that of " + parts_[replaced].directory.string();
      }
      events.push_back({now_utc_us, "merged", text});
    }
    SqliteStatement add(database_, "INSERT INTO event (at_utc_us, kind, text) VALUES (?1, ?2, ?3)");
    for (const Event& event : events) add.bind(event.at_utc_us, event.kind, event.text).run();
  }

  SqliteConnection* database_;
  std::span<const std::unique_ptr<SessionReader>> readers_;
  const std::vector<SessionPart>& parts_;
  const std::vector<MergedLine>& lines_;
  // Of an attempt of a part, its row in the merged session.
  std::map<std::pair<std::size_t, std::int64_t>, std::int64_t> attempt_row_{};
};

}  // namespace

void write_merged_database(const fs::path& directory,
                           std::span<const std::unique_ptr<SessionReader>> readers,
                           const std::vector<SessionPart>& parts,
                           const std::vector<MergedLine>& lines, const CapturePlan& plan,
                           std::int64_t now_utc_us) {
  for (const char* ending : {"", "-wal", "-shm"}) {  // of a merge that was stopped
    fs::remove(session_database_path(directory).string() + ending);
  }
  SqliteConnection database = open_session_to_write(directory);
  SqliteTransaction transaction(&database);
  MergedDatabase(&database, readers, parts, lines).write(plan, now_utc_us);
  transaction.commit();
}

}  // namespace raywalk::capture
