#include "calibrate/base/session_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/files/sqlite_connection.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// docs/session.md: PRAGMA application_id, "RWLK", and the newest supported format.
constexpr std::int64_t kApplicationId = 0x52574c4b;
constexpr std::int64_t kNewestFormat = 1;

SqliteConnection open_session(const fs::path& directory) {
  const fs::path file = session_database_of(directory);
  SqliteConnection database = open_sqlite_read_only(file);
  if (database.integer("PRAGMA application_id") != kApplicationId) {
    throw Error(file.string() + ": not a session of raywalk-capture; give another directory");
  }
  const std::int64_t format = database.integer("PRAGMA user_version");
  if (format > kNewestFormat) {
    throw Error(fmt::format(
        "{}: written by a newer raywalk-capture (format {}, this program supports up to {}); use "
        "the raywalk-calibrate of that version",
        file.string(), format, kNewestFormat));
  }
  return database;
}

FrameLayout layout_of(SqliteConnection* database, const CaptureInput& input) {
  SqliteStatement row(database, "SELECT frames, exposures FROM session");
  if (!row.step()) {
    throw Error(session_database_of(input.directory).string() +
                ": damaged: the table session is empty; restore it from a copy");
  }
  if (input.exposure < 0 || input.exposure >= row.integer(1)) {
    throw UsageError(
        fmt::format("{}: has {} exposure(s) of every station; --exposure must be 0 to {}",
                    input.directory.string(), row.integer(1), row.integer(1) - 1));
  }
  return row.text(0) == "panorama" ? FrameLayout::kPanorama : FrameLayout::kDualFisheye;
}

// File names of a session are within its directory; others may be a path traversal attack.
fs::path path_inside(const fs::path& directory, const std::string& file) {
  const fs::path path(file);
  bool inside = path.is_relative();
  for (const fs::path& part : path) inside = inside && part != "..";
  if (!inside) {
    throw Error(fmt::format("{}: lists the frame {}, which is not in its directory",
                            session_database_of(directory).string(), excerpt(file)));
  }
  return directory / path;
}

std::vector<CaptureLine> read_lines(SqliteConnection* database) {
  SqliteStatement row(database, "SELECT name, axis, across_m, validation FROM line ORDER BY id");
  std::vector<CaptureLine> lines;
  while (row.step()) {
    lines.push_back({.id = row.text(0),
                     .axis = row.text(1) == "x" ? LineAxis::kX : LineAxis::kZ,
                     .across_m = row.real(2),
                     .validation = row.integer(3) != 0});
  }
  return lines;
}

// Adds a picture, which may be the back lens's picture of the last frame.
void add_picture(SqliteStatement& row, const fs::path& directory, CaptureSet* set) {
  const fs::path path = path_inside(directory, row.text(0));
  const std::string name = row.text(3), lens = row.text(4);
  if (lens == "back" && !set->frames.empty() && set->frames.back().name == name) {
    set->frames.back().back = path;
    set->frames.back().sha256 += row.text(1);
    return;
  }
  if (lens == "back") {
    throw Error(
        fmt::format("{}: station {} has only the back lens's picture; import the front one, "
                    "or remove the station",
                    directory.string(), name));
  }
  const std::string line = row.text(2);
  const auto found = std::find_if(set->lines.begin(), set->lines.end(),
                                  [&](const CaptureLine& l) { return l.id == line; });
  set->frames.push_back({.name = name,
                         .line = static_cast<int>(found - set->lines.begin()),
                         .file = path,
                         .nominal_m = {row.real(5), 0.0, row.real(6)},
                         .sha256 = row.text(1)});
}

void read_frames(SqliteConnection* database, const CaptureInput& input, CaptureSet* set) {
  // Along each line by the feedback's position of the station; the front picture first.
  SqliteStatement row(
      database,
      "SELECT captured_frame.file, sha256, line.name, station, lens, x_m, z_m FROM captured_frame "
      "JOIN line ON line.name = captured_frame.line WHERE exposure = ?1 "
      "ORDER BY line.id, CASE line.axis WHEN 'x' THEN x_m ELSE z_m END, station, lens = 'back'");
  row.bind(input.exposure);
  while (row.step()) add_picture(row, input.directory, set);
}

void require_every_station(SqliteConnection* database, const CaptureInput& input,
                           const CaptureSet& set) {
  const std::int64_t stations = database->integer("SELECT count(*) FROM station");
  const auto captured = static_cast<std::int64_t>(set.frames.size());
  if (captured == stations || (input.partial && captured > 0)) return;
  const std::string of_what =
      input.exposure > 0 ? fmt::format(" (exposure {})", input.exposure) : std::string();
  throw Error(
      fmt::format("{}: {} of {} stations are captured{}; finish with raywalk-capture run or "
                  "import{}",
                  input.directory.string(), captured, stations, of_what,
                  captured > 0 ? ", or calibrate the captured ones with --partial" : ""));
}

// Either all frames have two files or none has.
void require_both_halves(const CaptureSet& set) {
  const auto has_back = [](const CaptureFrame& frame) { return frame.back.has_value(); };
  const auto halves = std::count_if(set.frames.begin(), set.frames.end(), has_back);
  if (halves == 0 || halves == static_cast<std::ptrdiff_t>(set.frames.size())) return;
  const auto lone = std::find_if_not(set.frames.begin(), set.frames.end(), has_back);
  throw Error(
      fmt::format("{}: station {} has no picture of the back lens, but others have; import it",
                  set.source.string(), lone->name));
}

}  // namespace

fs::path session_database_of(const fs::path& directory) { return directory / "session.db"; }

CaptureSet read_session_frames(const CaptureInput& input) {
  SqliteConnection database = open_session(input.directory);
  CaptureSet set;
  set.source = input.directory;
  set.layout = layout_of(&database, input);
  set.lines = read_lines(&database);
  read_frames(&database, input, &set);
  require_every_station(&database, input, set);
  require_both_halves(set);
  return set;
}

}  // namespace raywalk::calibrate
