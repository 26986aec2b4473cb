#include "capture/session/merge_sessions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "capture/plan/line_selection.h"
#include "capture/session/session_database.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/file_lock.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/session/session_contents.h"
#include "core/session/session_file.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// A session that is to be merged with others.
struct Part {
  explicit Part(const fs::path& session);

  SessionReader reader;
  // So that it is not captured meanwhile; none on a read-only disk.
  std::unique_ptr<FileLock> lock{};
  fs::path directory{};  // absolute
  std::string name{};    // of the directory, for events
  SessionFacts facts{};
  CapturePlan plan{};
  WholePlan whole{};         // that of which it is a part, or its own
  std::string frame_size{};  // "64 x 32"; empty if it has no frame
};
using Parts = std::vector<std::unique_ptr<Part>>;

// A line and the session that it is taken from, which has captured a station of it or recorded it.
struct MergedLine {
  std::string id{};
  const Part* part = nullptr;
  int captured = 0;                     // stations, also with pictures still on the card
  int planned = 0;                      // stations
  std::int64_t ended_utc_us = 0;        // of its last captured station or its video
  std::vector<const Part*> replaced{};  // sessions whose older line is not taken
};

Part::Part(const fs::path& session)
    : reader(session),
      directory(without_trailing_slash(fs::absolute(session).lexically_normal())),
      name(directory.filename().string()) {
  if (::access(directory.c_str(), W_OK) == 0) {
    lock = std::make_unique<FileLock>(
        directory / "session.lock",
        "another raywalk-capture uses this session, or it is given twice; wait for it");
  }
  require_no_faults(frame_faults(reader.contents()), session);
  facts = reader.facts();
  plan = reader.plan();
  whole = whole_plan_of(plan, facts.camera_config());
  const auto size = reader.frame_size();
  if (size) frame_size = fmt::format("{} x {}", size->width, size->height);
}

// Throws Error unless the sessions are of one camera, one mode and one plan.
void require_same_capture(const Part& a, const Part& b) {
  const auto refuse = [&](const std::string& what) {
    throw Error(fmt::format("{} and {} cannot be merged: {}", a.directory.string(),
                            b.directory.string(), what));
  };
  const auto require_same = [&](const char* what, std::string_view there, std::string_view here) {
    if (there != here) refuse(fmt::format("{} is {} and {}", what, there, here));
  };
  require_same("the camera", name_of(a.facts.camera), name_of(b.facts.camera));
  require_same("the mode", name_of(a.facts.mode), name_of(b.facts.mode));
  require_same("frames", name_of(a.facts.frames), name_of(b.facts.frames));
  if (!a.frame_size.empty() && !b.frame_size.empty()) {
    require_same("the size of pictures", a.frame_size, b.frame_size);
  }
  if (a.whole.sha256 != b.whole.sha256) {
    refuse("they are of different plans: other lines, stations or exposures");
  }
}

// The sessions in the order of time.
Parts read_parts(const std::vector<fs::path>& sessions) {
  Parts parts;
  bool same_exposure = true;
  for (const fs::path& session : sessions) {
    parts.push_back(std::make_unique<Part>(session));
    require_same_capture(*parts.front(), *parts.back());
    same_exposure &= parts.front()->facts.locked_exposure == parts.back()->facts.locked_exposure;
  }
  if (!same_exposure) {
    spdlog::warn(
        "the sessions have different exposures; raywalk-build-lf gains makes their stations agree");
  }
  std::ranges::stable_sort(parts, {}, [](const auto& part) { return part->facts.created; });
  return parts;
}

// What the sessions have of each line, by its id, the newest last.
std::map<std::string, std::vector<MergedLine>> captured_lines(const Parts& parts) {
  constexpr int kMostStations = 1 << 30;
  std::map<std::string, std::vector<MergedLine>> lines;
  for (const auto& part : parts) {
    SqliteStatement row = part->reader.query(
        "SELECT line.name, count(attempt.id), count(*), max(coalesce(max(ended_utc_us), 0), "
        "coalesce((SELECT max(at_utc_us) FROM journal WHERE line_id = line.id), 0)) AS last_utc_us "
        "FROM line JOIN station ON line_id = line.id LEFT JOIN attempt ON station_id = station.id "
        "AND outcome IN ('captured', 'exposed') GROUP BY line.id HAVING last_utc_us > 0",
        "a captured line");
    while (row.step()) {
      lines[row.name(0)].push_back({.id = row.name(0),
                                    .part = part.get(),
                                    .captured = row.number(1, 0, kMostStations),
                                    .planned = row.number(2, 0, kMostStations),
                                    .ended_utc_us = row.utc_us(3)});
    }
  }
  for (auto& [id, of_line] : lines) {
    std::ranges::stable_sort(of_line, {}, &MergedLine::ended_utc_us);
  }
  return lines;
}

// The lines that the sessions have, in the order of the whole plan, each of the session that
// captured it last.
std::vector<MergedLine> lines_of(const Parts& parts, const MergeOptions& options) {
  auto captured = captured_lines(parts);
  std::vector<MergedLine> lines;
  std::vector<std::string> missing, unfinished;
  for (const std::string& id : parts.front()->whole.lines) {
    std::vector<MergedLine>& of_line = captured[id];
    if (of_line.empty()) {
      missing.push_back(id);
      continue;
    }
    if (of_line.size() > 1 && !options.replace) {
      throw Error(fmt::format(
          "line {} is captured in {} and, later, in {}; leave one of them out, or take the "
          "later one with --replace",
          id, of_line[0].part->directory.string(), of_line[1].part->directory.string()));
    }
    MergedLine& line = lines.emplace_back(std::move(of_line.back()));
    of_line.pop_back();
    for (const MergedLine& older : of_line) line.replaced.push_back(older.part);
    if (line.captured < line.planned && line.part->facts.mode == CaptureMode::kStations) {
      unfinished.push_back(fmt::format("{} ({} of {})", id, line.captured, line.planned));
    }
  }
  if (lines.empty()) throw Error("none of the sessions has captured a station");
  if (options.partial || (missing.empty() && unfinished.empty())) return lines;
  std::vector<std::string> what;
  if (!missing.empty()) {
    what.push_back(fmt::format("no session has {} of the plan: {}", counted(missing.size(), "line"),
                               fmt::join(missing, ", ")));
  }
  if (!unfinished.empty()) {
    what.push_back(fmt::format("{} not finished: {}", counted(unfinished.size(), "line"),
                               fmt::join(unfinished, ", ")));
  }
  throw Error(fmt::format("{}; capture them, or merge what is there with --partial",
                          fmt::join(what, "; ")));
}

// The merged plan: whole where no line is missing.
CapturePlan plan_of_lines(const Parts& parts, const std::vector<MergedLine>& lines) {
  CapturePlan plan;
  for (const MergedLine& line : lines) {
    plan.lines.push_back(*std::ranges::find(line.part->plan.lines, line.id, &CaptureLine::id));
  }
  const Part& any = *parts.front();
  if (lines.size() < any.whole.lines.size()) {
    plan.part_of = any.whole;
  } else if (whole_plan_of(plan, any.facts.camera_config()).sha256 != any.whole.sha256) {
    throw Error("the lines of the sessions do not make up the plan that they were started with");
  }
  return plan;
}

// Creates the folder that becomes the session, or goes on with one that a stopped merge left.
void make_merged_folder(const fs::path& directory) {
  make_directories(directory / kFramesDirectory);
  const std::string other = foreign_name(directory);
  if (other.empty()) return;
  throw Error(
      fmt::format("{}: holds {}, which no merge writes there; remove it or give another --out",
                  directory.string(), excerpt(other)));
}

// Copies the rows of a session's lines, and all its events. An attempt that a killed run left open
// is none.
void copy_rows(SqliteConnection* database, Part* part, const std::vector<MergedLine>& lines) {
  std::vector<std::string> ids;
  for (const MergedLine& line : lines) {
    if (line.part == part) ids.push_back(line.id);
  }
  const std::string taken = nlohmann::json(ids).dump();
  const std::int64_t attempts = database->integer("SELECT max(id) FROM attempt");
  database->attach(part->reader.database(), "part");
  SqliteTransaction transaction(database);
  database->run(
      "INSERT INTO attempt SELECT a.id + ?2, mine.id, a.number, outcome, begun_utc_us, "
      "ended_utc_us, commanded_mm, measured_mm, moving_ms, settling_ms, triggered_utc_us, "
      "exposed_utc_us, exposing_ms, transfer_ms, own_ms, fault, message FROM part.attempt AS a "
      "JOIN part.station AS theirs ON theirs.id = a.station_id "
      "JOIN part.line AS line ON line.id = theirs.line_id "
      "JOIN main.station AS mine ON mine.name = theirs.name "
      "WHERE line.name IN (SELECT value FROM json_each(?1)) AND outcome IS NOT NULL",
      taken, attempts);
  database->run(
      "INSERT INTO frame SELECT NULL, attempt_id + ?1, exposure, lens, file, bytes, sha256, "
      "width_px, height_px, camera_name, settings FROM part.frame "
      "WHERE attempt_id + ?1 IN (SELECT id FROM main.attempt) ORDER BY id",
      attempts);
  database->run(
      "INSERT INTO journal SELECT NULL, mine.id, at_utc_us, position_mm FROM part.journal "
      "JOIN part.line AS theirs ON theirs.id = line_id "
      "JOIN main.line AS mine ON mine.name = theirs.name "
      "WHERE theirs.name IN (SELECT value FROM json_each(?1)) ORDER BY part.journal.id",
      taken);
  database->run(
      "INSERT INTO event SELECT NULL, at_utc_us, kind, ?1 || ': ' || text FROM part.event "
      "ORDER BY id",
      part->name);
  transaction.commit();
  database->execute("DETACH part");
}

// Writes session.db anew, session by session in the order of time. Exposure and configuration are
// those of the session that captured last.
void write_database(const fs::path& directory, const Parts& parts,
                    const std::vector<MergedLine>& lines, const CapturePlan& plan,
                    std::int64_t now_utc_us) {
  for (const char* ending : {"", "-wal", "-shm"}) {  // of a merge that was stopped
    fs::remove(session_database_path(directory).string() + ending);
  }
  SqliteConnection database = open_session_to_write(directory);
  SessionFacts facts = std::ranges::max_element(lines, {}, &MergedLine::ended_utc_us)->part->facts;
  facts.created = parts.front()->facts.created;
  create_session(&database, facts, plan);
  for (const auto& part : parts) copy_rows(&database, part.get(), lines);
  SqliteTransaction transaction(&database);
  for (const MergedLine& line : lines) {
    std::string text = fmt::format("{}: {} of {}", line.id,
                                   counted(static_cast<std::size_t>(line.captured), "station"),
                                   line.part->directory.string());
    for (const Part* older : line.replaced) {
      text += ", in place of that of " + older->directory.string();
    }
    database.run("INSERT INTO event (at_utc_us, kind, text) VALUES (?1, 'merged', ?2)", now_utc_us,
                 text);
  }
  transaction.commit();
}

// Links or copies a frame, unless an earlier run did. A link is the same file; a copy is read.
void take_frame(const fs::path& source, const std::string& sha256, const fs::path& target) {
  std::error_code error;
  if (fs::equivalent(source, target, error)) return;
  if (fs::exists(target) && sha256_of_file(target) == sha256) return;
  fs::remove(target);
  fs::create_hard_link(source, target, error);
  if (!error) return;
  AtomicFile copy(target);
  fs::copy_file(source, copy.temporary_path(), error);
  if (error) {
    throw Error(fmt::format("cannot copy {} to {}: {}; the same command goes on from here",
                            source.string(), target.string(), error.message()));
  }
  copy.commit();
}

// Takes the frames that the merged session names and removes those of other merges; on the disk
// when it returns.
void take_frames(const std::vector<MergedLine>& lines, const SessionContents& merged) {
  std::set<std::string> wanted;
  for (const SessionFrame& frame : merged.frames) wanted.insert(frame.file);
  for (const std::string& file : list_frames(merged.directory)) {
    if (!wanted.contains(file)) fs::remove(merged.directory / file);
  }
  Progress progress("merging", static_cast<std::int64_t>(merged.frames.size()), "frames");
  for (const SessionFrame& frame : merged.frames) {
    throw_if_interrupted();
    // Both are in the order of the plan.
    const int line = merged.station_of(frame).line;
    const Part& part = *lines[static_cast<std::size_t>(line)].part;
    take_frame(part.directory / frame.file, frame.sha256, merged.directory / frame.file);
    progress.advance();
  }
  sync_directory(merged.directory / kFramesDirectory);
}

std::string summary_of(const Parts& parts, const std::vector<MergedLine>& lines, std::size_t frames,
                       const fs::path& out) {
  std::string text =
      fmt::format("{}: {} and {} of {}", escaped(out.string()), counted(frames, "frame"),
                  counted(lines.size(), "line"), counted(parts.size(), "session"));
  for (const MergedLine& line : lines) {
    for (const Part* replaced : line.replaced) {
      text += fmt::format("; {} of {} replaces that of {}", line.id, escaped(line.part->name),
                          escaped(replaced->name));
    }
  }
  std::vector<std::string> missing = parts.front()->whole.lines;
  std::erase_if(missing, [&](const std::string& id) {
    return std::ranges::find(lines, id, &MergedLine::id) != lines.end();
  });
  if (!missing.empty()) text += fmt::format("; missing: {}", fmt::join(missing, ", "));
  return text + fmt::format("; next: raywalk-capture status {}", escaped(out.string()));
}

}  // namespace

std::string merge_sessions(const MergeOptions& options, Clock* clock) {
  const fs::path out = without_trailing_slash(options.out);
  require_absent(out, "--out");
  const Parts parts = read_parts(options.sessions);
  const std::vector<MergedLine> lines = lines_of(parts, options);
  const CapturePlan plan = plan_of_lines(parts, lines);
  const fs::path partial = out.string() + ".partial";
  make_merged_folder(partial);
  SessionContents merged;
  {
    const FileLock lock(partial / "session.lock",
                        "another raywalk-capture merges sessions into it");
    write_database(partial, parts, lines, plan, utc_us_from(clock->wall_now()));
    merged = SessionReader(partial).contents();
    take_frames(lines, merged);
    require_no_faults(frame_faults(merged), partial);
  }
  move_into_place(partial, out);
  return summary_of(parts, lines, merged.frames.size(), out);
}

}  // namespace raywalk::capture
