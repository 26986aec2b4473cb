#include "capture/session/session_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "capture/session/session_database.h"
#include "capture/session/session_times.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

StationState state_of(const std::string& outcome) {
  if (outcome == "captured") return StationState::kCaptured;
  return outcome == "exposed" ? StationState::kExposed : StationState::kPlanned;
}

// The enumerator that the database names by `word`.
template <typename Enum, std::size_t count>
Enum choice_of(const std::string& word, const std::array<Enum, count>& choices,
               const std::filesystem::path& directory) {
  const auto choice = std::find_if(choices.begin(), choices.end(),
                                   [&](Enum each) { return name_of(each) == word; });
  if (choice != choices.end()) return *choice;
  throw Error(
      fmt::format("{}: damaged: the table session holds the unknown value {}; "
                  "restore it from a copy",
                  session_database_path(directory).string(), excerpt(word)));
}

FrameLens lens_of(const std::string& word) {
  if (word == "front") return FrameLens::kFront;
  return word == "back" ? FrameLens::kBack : FrameLens::kBoth;
}

std::optional<WallTime> time_of(std::optional<std::int64_t> utc_us) {
  return utc_us ? std::optional(wall_time_from(*utc_us)) : std::nullopt;
}

// A session only writes names within its directory; any other may be an attack.
void require_inside(const std::string& file, const std::filesystem::path& directory) {
  const std::filesystem::path path(file);
  bool inside = path.is_relative();
  for (const std::filesystem::path& part : path) inside = inside && part != "..";
  if (inside) return;
  throw Error(fmt::format("{}: names the frame {}, which is not in its directory",
                          session_database_path(directory).string(), excerpt(file)));
}

}  // namespace

SessionReader::SessionReader(std::filesystem::path directory)
    : directory_(std::move(directory)), database_(open_session_to_read(directory_)) {}

SessionFacts SessionReader::facts() {
  SqliteStatement row(&database_,
                      "SELECT created_utc_us, mode, camera, frames, exposures, locked_exposure, "
                      "config_text FROM session");
  if (!row.step()) {
    throw Error(
        fmt::format("{}: damaged: the table session has no row; restore it from a "
                    "copy",
                    session_database_path(directory_).string()));
  }
  return {.created = wall_time_from(row.integer(0)),
          .mode = choice_of(row.text(1), kCaptureModes, directory_),
          .camera = choice_of(row.text(2), kCameraKinds, directory_),
          .frames = choice_of(row.text(3), kFrameKinds, directory_),
          .exposures = static_cast<int>(row.integer(4)),
          .locked_exposure = row.text(5),
          .config_text = row.text(6)};
}

CapturePlan SessionReader::plan() { return read_plan(&database_); }

std::vector<StationRecord> SessionReader::stations() {
  SqliteStatement row(
      &database_,
      "SELECT line.name, station.name, planned_mm, outcome, attempt.id, attempt.number, "
      "measured_mm, triggered_utc_us, exposed_utc_us FROM station "
      "JOIN line ON line.id = station.line_id LEFT JOIN attempt ON attempt.station_id = station.id "
      "AND outcome IN ('captured', 'exposed') ORDER BY station.line_id, station.number");
  std::vector<StationRecord> stations;
  while (row.step()) {
    const std::string name = row.text(1);
    stations.push_back({.line = row.text(0),
                        .name = name,
                        .planned_mm = row.real(2),
                        .state = state_of(row.text(3)),
                        .attempt = {row.integer(4), name, static_cast<int>(row.integer(5))},
                        .measured_mm = row.optional_real(6),
                        .triggered_at = time_of(row.optional_integer(7)),
                        .exposed_at = time_of(row.optional_integer(8))});
  }
  return stations;
}

std::vector<FrameRecord> SessionReader::frames() {
  SqliteStatement row(
      &database_,
      "SELECT captured_frame.file, bytes, sha256, line, station, captured_frame.validation, "
      "exposure, lens, x_m, z_m FROM captured_frame JOIN line ON line.name = captured_frame.line "
      "ORDER BY line.id, number, exposure, lens");
  std::vector<FrameRecord> frames;
  while (row.step()) {
    frames.push_back({.file = row.text(0),
                      .bytes = row.integer(1),
                      .sha256 = row.text(2),
                      .line = row.text(3),
                      .station = row.text(4),
                      .validation = row.integer(5) != 0,
                      .exposure_index = static_cast<int>(row.integer(6)),
                      .lens = lens_of(row.text(7)),
                      .position_m = {row.real(8), row.real(9)}});
    require_inside(frames.back().file, directory_);
  }
  return frames;
}

std::vector<JournalSample> SessionReader::journal(const std::string& line) {
  SqliteStatement row(&database_,
                      "SELECT at_utc_us, position_mm FROM journal JOIN line ON line.id = line_id "
                      "WHERE line.name = ?1 ORDER BY journal.id");
  row.bind(line);
  std::vector<JournalSample> samples;
  while (row.step()) samples.push_back({wall_time_from(row.integer(0)), row.real(1)});
  return samples;
}

}  // namespace raywalk::capture
