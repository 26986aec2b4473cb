#include "capture/session/merge_sessions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "capture/plan/line_selection.h"
#include "capture/session/merged_files.h"
#include "capture/session/merged_rows.h"
#include "capture/session/session_part.h"
#include "capture/session/session_times.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/files/file_lock.h"
#include "core/files/output_folder.h"
#include "core/session/session_contents.h"
#include "core/session/session_file.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

const CapturedLine* find_line(const SessionPart& part, const std::string& id) {
  const auto line = std::ranges::find(part.lines, id, &CapturedLine::id);
  return line == part.lines.end() ? nullptr : &*line;
}

// The part that a line is taken from: the one that captured it last.
std::optional<MergedLine> choose(const std::vector<SessionPart>& parts, const std::string& id,
                                 bool replace) {
  std::optional<MergedLine> chosen;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const CapturedLine* line = find_line(parts[i], id);
    if (line == nullptr) continue;
    if (!chosen) {
      chosen = MergedLine{.id = id, .part = i, .captured = *line};
      continue;
    }
    const bool is_newer = line->ended_utc_us > chosen->captured.ended_utc_us;
    const fs::path& newer = parts[is_newer ? i : chosen->part].directory;
    const fs::path& older = parts[is_newer ? chosen->part : i].directory;
    if (!replace) {
      throw Error(fmt::format(
          "line {} is captured in {} and, later, in {}; leave one of them out, or take the later "
          "one with --replace",
          id, older.string(), newer.string()));
    }
    if (is_newer) {
      chosen->replaced.push_back(chosen->part);
      chosen->part = i;
      chosen->captured = *line;
    } else {
      chosen->replaced.push_back(i);
    }
  }
  return chosen;
}

// The lines that the parts have, in the order of the whole plan.
std::vector<MergedLine> lines_of(const std::vector<SessionPart>& parts,
                                 const MergeOptions& options) {
  std::vector<MergedLine> lines;
  std::vector<std::string> missing, unfinished;
  for (const std::string& id : parts.front().whole.lines) {
    const std::optional<MergedLine> line = choose(parts, id, options.replace);
    if (!line) {
      missing.push_back(id);
      continue;
    }
    if (!line->captured.finished() && parts[line->part].facts.mode == CaptureMode::kStations) {
      unfinished.push_back(
          fmt::format("{} ({} of {})", id, line->captured.captured, line->captured.planned));
    }
    lines.push_back(*line);
  }
  if (lines.empty()) throw Error("none of the sessions has captured a station");
  if (options.partial || (missing.empty() && unfinished.empty())) return lines;
  std::string what;
  if (!missing.empty()) {
    what = fmt::format("no session has {} of the plan: {}", counted(missing.size(), "line"),
                       fmt::join(missing, ", "));
  }
  if (!unfinished.empty()) {
    what += fmt::format("{}{} not finished: {}", what.empty() ? "" : "; ",
                        counted(unfinished.size(), "line"), fmt::join(unfinished, ", "));
  }
  throw Error(what + "; capture them, or merge what is there with --partial");
}

// The merged plan: whole where no line is missing.
CapturePlan plan_of_lines(const std::vector<SessionPart>& parts,
                          const std::vector<MergedLine>& lines) {
  CapturePlan plan;
  for (const MergedLine& line : lines) {
    plan.lines.push_back(
        *std::ranges::find(parts[line.part].plan.lines, line.id, &CaptureLine::id));
  }
  const WholePlan& whole = parts.front().whole;
  if (lines.size() < whole.lines.size()) plan.part_of = whole;
  return plan;
}

std::vector<MergedFrame> frames_of(const std::vector<SessionPart>& parts,
                                   const std::vector<MergedLine>& lines) {
  std::vector<MergedFrame> frames;
  for (const MergedLine& line : lines) {
    const SessionContents& contents = parts[line.part].contents;
    for (const SessionFrame& frame : contents.frames) {
      if (contents.line_of(contents.station_of(frame)).id != line.id) continue;
      frames.push_back({parts[line.part].directory / frame.file, frame.file, frame.sha256});
    }
  }
  return frames;
}

// Locks the sessions, so that none is captured meanwhile; those on read-only disks cannot be.
std::vector<std::unique_ptr<FileLock>> lock_sessions(const std::vector<fs::path>& sessions) {
  std::vector<std::unique_ptr<FileLock>> locks;
  for (const fs::path& directory : sessions) {
    open_session_to_read(directory);  // throws if there is none, before a lock file is created
    if (::access(directory.c_str(), W_OK) != 0) continue;
    locks.push_back(std::make_unique<FileLock>(
        directory / "session.lock",
        "another raywalk-capture uses this session, or it is given twice; wait for it"));
  }
  return locks;
}

void warn_of_exposures(const std::vector<SessionPart>& parts) {
  std::set<std::string> exposures;
  for (const SessionPart& part : parts) exposures.insert(part.facts.locked_exposure);
  if (exposures.size() < 2) return;
  spdlog::warn(
      "the sessions have different exposures; raywalk-build-lf gains makes their stations agree");
}

std::string summary_of(const std::vector<SessionPart>& parts, const std::vector<MergedLine>& lines,
                       const CapturePlan& plan, std::size_t frames, const fs::path& out) {
  std::string text =
      fmt::format("{}: {} and {} of {}", escaped(out.string()), counted(frames, "frame"),
                  counted(lines.size(), "line"), counted(parts.size(), "session"));
  for (const MergedLine& line : lines) {
    for (const std::size_t replaced : line.replaced) {
      text += fmt::format("; {} of {} replaces that of {}", line.id, escaped(parts[line.part].name),
                          escaped(parts[replaced].name));
    }
  }
  if (plan.part_of) {
    std::vector<std::string> missing;
    for (const std::string& id : plan.part_of->lines) {
      if (std::ranges::find(lines, id, &MergedLine::id) == lines.end()) missing.push_back(id);
    }
    text += fmt::format("; missing: {}", fmt::join(missing, ", "));
  }
  return text + fmt::format("; next: raywalk-capture status {}", escaped(out.string()));
}

}  // namespace

std::string merge_sessions(const MergeOptions& options, Clock* clock) {
  const fs::path out = without_trailing_slash(options.out);
  require_absent(out, "--out");
  const auto locks = lock_sessions(options.sessions);
  std::vector<std::unique_ptr<SessionReader>> readers;
  std::vector<SessionPart> parts;
  for (const fs::path& directory : options.sessions) {
    readers.push_back(std::make_unique<SessionReader>(directory));
    parts.push_back(read_session_part(readers.back().get()));
  }
  require_same_capture(parts);
  const std::vector<MergedLine> lines = lines_of(parts, options);
  const CapturePlan plan = plan_of_lines(parts, lines);
  if (!plan.part_of && grid_sha256(plan, parts.front().camera) != parts.front().whole.sha256) {
    throw Error("the lines of the sessions do not make up the plan that they were started with");
  }
  warn_of_exposures(parts);
  const std::vector<MergedFrame> frames = frames_of(parts, lines);
  const fs::path partial = out.string() + ".partial";
  {
    const MergedFiles files(partial);
    files.take(frames);
    write_merged_database(partial, readers, parts, lines, plan, utc_us_from(clock->wall_now()));
    require_no_faults(frame_faults(SessionReader(partial).contents()), partial);
  }
  move_into_place(partial, out);
  return summary_of(parts, lines, plan, frames.size(), out);
}

}  // namespace raywalk::capture
