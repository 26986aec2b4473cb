#include "calibrate/base/session_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/median.h"
#include "core/files/frame_list.h"
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

[[noreturn]] void fail_damaged(const fs::path& directory, const std::string& what) {
  throw Error(fmt::format("{}: damaged: {}; restore it from a copy",
                          session_database_of(directory).string(), what));
}

FrameLayout layout_of(SqliteConnection* database, const CaptureInput& input) {
  SqliteStatement row(database, "SELECT frames, exposures FROM session");
  if (!row.step()) fail_damaged(input.directory, "the table session is empty");
  const std::string layout = row.text(0);
  if (layout != "panorama" && layout != "dual-fisheye") {
    fail_damaged(input.directory, "frames in the table session is " + excerpt(layout) +
                                      ", neither 'panorama' nor 'dual-fisheye'");
  }
  if (row.integer(1) < 1) {
    fail_damaged(input.directory, "exposures in the table session is not a number from 1 on");
  }
  if (input.exposure < 0 || input.exposure >= row.integer(1)) {
    throw UsageError(
        fmt::format("{}: has {} exposure(s) of every station; --exposure must be 0 to {}",
                    input.directory.string(), row.integer(1), row.integer(1) - 1));
  }
  return layout == "panorama" ? FrameLayout::kPanorama : FrameLayout::kDualFisheye;
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

// A column that holds a place in metres; `what` names row and column.
double place_m(const SqliteStatement& row, int column, const fs::path& directory,
               const std::string& what) {
  if (!row.is_number(column)) fail_damaged(directory, what + " is missing or not a number");
  const double value = row.real(column);
  if (std::abs(value) <= kMaxPosition_m) return value;
  fail_damaged(directory, fmt::format("{} is {:g}, which is no place in metres (at most {:g})",
                                      what, value, kMaxPosition_m));
}

// Names of stations and lines are parts of file names.
std::string checked_name(const std::string& name, const fs::path& directory,
                         const std::string& what) {
  constexpr std::size_t kLongest = 100;
  const bool fits = !name.empty() && name.size() <= kLongest && name != "." && name != ".." &&
                    name.find('/') == std::string::npos && escaped(name) == name;
  if (!fits) fail_damaged(directory, what + " has the name " + excerpt(name));
  return name;
}

std::vector<CaptureLine> read_lines(SqliteConnection* database, const fs::path& directory) {
  SqliteStatement row(database, "SELECT name, axis, across_m, validation FROM line ORDER BY id");
  std::vector<CaptureLine> lines;
  while (row.step()) {
    const std::string name = checked_name(row.text(0), directory, "a line"), axis = row.text(1);
    if (axis != "x" && axis != "z") {
      fail_damaged(directory,
                   fmt::format("line {}: axis is {}, neither 'x' nor 'z'", name, excerpt(axis)));
    }
    lines.push_back({.id = name,
                     .axis = axis == "x" ? LineAxis::kX : LineAxis::kZ,
                     .across_m = place_m(row, 2, directory, "line " + name + ": across_m"),
                     .validation = row.integer(3) != 0});
  }
  return lines;
}

// The places of a station: captured, and planned.
struct StationPlaces {
  PlanPoint captured{};
  PlanPoint planned{};
};

StationPlaces places_of(const SqliteStatement& row, int column, const fs::path& directory,
                        const std::string& station) {
  const auto place = [&](int offset, const char* what) {
    return place_m(row, column + offset, directory, fmt::format("station {}: {}", station, what));
  };
  return {.captured = {place(0, "the captured x_m"), place(1, "the captured z_m")},
          .planned = {place(2, "the planned x_m"), place(3, "the planned z_m")}};
}

// Adds a picture, which may be the back lens's picture of the last frame; then `planned` gets the
// planned place of its station.
void add_picture(const SqliteStatement& row, const fs::path& directory, CaptureSet* set,
                 std::vector<PlanPoint>* planned) {
  const std::string name = checked_name(row.text(3), directory, "a station"), lens = row.text(4);
  const fs::path path = path_inside(directory, row.text(0));
  if (lens != "both" && lens != "front" && lens != "back") {
    fail_damaged(directory, fmt::format("station {}: the frame's lens is {}, neither 'both', "
                                        "'front' nor 'back'",
                                        name, excerpt(lens)));
  }
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
  const StationPlaces places = places_of(row, 5, directory, name);
  const std::string line = row.text(2);
  const auto found = std::find_if(set->lines.begin(), set->lines.end(),
                                  [&](const CaptureLine& l) { return l.id == line; });
  set->frames.push_back({.name = name,
                         .line = static_cast<int>(found - set->lines.begin()),
                         .file = path,
                         .nominal_m = {places.captured.x_m, 0.0, places.captured.z_m},
                         .sha256 = row.text(1)});
  planned->push_back(places.planned);
}

void require_distinct_names(const CaptureSet& set) {
  std::set<std::string> names;
  for (const CaptureFrame& frame : set.frames) {
    if (names.insert(frame.name).second) continue;
    fail_damaged(set.source, fmt::format("station {} has several frames", frame.name));
  }
}

double along_m(const CaptureLine& line, PlanPoint at) {
  return line.axis == LineAxis::kX ? at.x_m : at.z_m;
}
double across_m(const CaptureLine& line, PlanPoint at) {
  return line.axis == LineAxis::kX ? at.z_m : at.x_m;
}

// How far a station of the line may be from its planned place: half of the stations' spacing, as
// raywalk-capture accepts none that is nearer to another's place.
double farthest_off_plan_m(const CaptureSet& set, std::size_t line,
                           const std::vector<PlanPoint>& planned) {
  constexpr double kLoneStation_m = 1.0;
  std::vector<double> places_m;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    if (static_cast<std::size_t>(set.frames[i].line) == line) {
      places_m.push_back(along_m(set.lines[line], planned[i]));
    }
  }
  if (places_m.size() < 2) return kLoneStation_m;
  std::sort(places_m.begin(), places_m.end());
  std::vector<double> gaps_m;
  for (std::size_t i = 1; i < places_m.size(); ++i) gaps_m.push_back(places_m[i] - places_m[i - 1]);
  return 0.5 * median(std::move(gaps_m));
}

void require_near_plan(const CaptureSet& set, const std::vector<PlanPoint>& planned) {
  constexpr double kRounding_m = 1e-6;
  std::vector<double> farthest_m;
  for (std::size_t line = 0; line < set.lines.size(); ++line) {
    farthest_m.push_back(farthest_off_plan_m(set, line, planned) + kRounding_m);
  }
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    const CaptureFrame& frame = set.frames[i];
    const auto line = static_cast<std::size_t>(frame.line);
    const PlanPoint plan = planned[i];
    if (std::abs(across_m(set.lines[line], plan) - set.lines[line].across_m) > kRounding_m) {
      fail_damaged(set.source,
                   fmt::format("station {} is planned at x = {:g} m, z = {:g} m, which is not on "
                               "its line {} (across_m is {:g})",
                               frame.name, plan.x_m, plan.z_m, set.lines[line].id,
                               set.lines[line].across_m));
    }
    const double off_m = std::hypot(frame.nominal_m.x() - plan.x_m, frame.nominal_m.z() - plan.z_m);
    if (off_m <= farthest_m[line]) continue;
    fail_damaged(set.source,
                 fmt::format("station {} was captured at x = {:g} m, z = {:g} m, but planned at "
                             "x = {:g} m, z = {:g} m: {:g} m away, where at most {:g} m can be",
                             frame.name, frame.nominal_m.x(), frame.nominal_m.z(), plan.x_m,
                             plan.z_m, off_m, farthest_m[line]));
  }
}

// The frames of a line are in the order of their places.
void require_distinct_places(const CaptureSet& set) {
  constexpr double kSamePlace_m = 1e-6;  // finer than any slider's feedback
  for (std::size_t i = 1; i < set.frames.size(); ++i) {
    const CaptureFrame &one = set.frames[i - 1], &next = set.frames[i];
    const auto at = static_cast<int>(i);
    if (one.line != next.line || set.rail_m(at) - set.rail_m(at - 1) > kSamePlace_m) continue;
    fail_damaged(
        set.source,
        fmt::format("stations {} and {} are at the same place of their line, "
                    "{} = {:g} m",
                    one.name, next.name,
                    name_of(set.lines[static_cast<std::size_t>(one.line)].axis), set.rail_m(at)));
  }
}

void read_frames(SqliteConnection* database, const CaptureInput& input, CaptureSet* set) {
  // Along each line by the feedback's position of the station; the front picture first.
  SqliteStatement row(
      database,
      "SELECT captured.file, captured.sha256, line.name, captured.station, captured.lens, "
      "captured.x_m, captured.z_m, station.x_m, station.z_m FROM captured_frame AS captured "
      "JOIN line ON line.name = captured.line LEFT JOIN station ON station.name = captured.station "
      "WHERE captured.exposure = ?1 "
      "ORDER BY line.id, CASE line.axis WHEN 'x' THEN captured.x_m ELSE captured.z_m END, "
      "captured.station, captured.lens = 'back'");
  row.bind(input.exposure);
  std::vector<PlanPoint> planned;
  while (row.step()) add_picture(row, input.directory, set, &planned);
  require_distinct_names(*set);
  require_near_plan(*set, planned);
  require_distinct_places(*set);
}

void require_every_station(SqliteConnection* database, const CaptureInput& input,
                           const CaptureSet& set) {
  const std::int64_t stations = database->integer("SELECT count(*) FROM station");
  if (stations == 0) {
    throw Error(fmt::format(
        "{}: plans no stations, so there is nothing to calibrate; give another session, or restore "
        "this one from a copy",
        session_database_of(input.directory).string()));
  }
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
  set.lines = read_lines(&database, input.directory);
  read_frames(&database, input, &set);
  require_every_station(&database, input, set);
  require_both_halves(set);
  return set;
}

}  // namespace raywalk::calibrate
