#include "capture/session/session_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "capture/session/session_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

void require_exposure(int exposure, const SessionFacts& facts, const std::string& directory) {
  if (exposure >= 0 && exposure < facts.exposures()) return;
  throw UsageError(fmt::format("{}: has {} exposure(s) of every station; --exposure takes 0 to {}",
                               directory, facts.exposures(), facts.exposures() - 1));
}

void require_panoramas(const std::vector<SessionFrame>& frames, const SessionFacts& facts,
                       const std::string& directory) {
  const bool halves = std::ranges::any_of(
      frames, [](const SessionFrame& frame) { return frame.lens != FrameLens::kBoth; });
  if (facts.frames == FrameKind::kPanorama && !halves) return;
  throw Error(
      fmt::format("{}: its frames are fisheye pictures, not panoramas; stitch them with "
                  "raywalk-calibrate, or export them as they are with --unstitched",
                  directory));
}

bool is_captured(const SessionStation& station) { return station.shot && !station.shot->on_card; }

void require_finished(const std::vector<SessionStation>& stations, const std::string& directory) {
  const SessionStation* first = nullptr;
  std::size_t planned = 0, exposed = 0;
  for (const SessionStation& station : stations) {
    if (is_captured(station)) continue;
    if (first == nullptr) first = &station;
    ++(station.shot ? exposed : planned);
  }
  if (first == nullptr) return;
  throw Error(
      fmt::format("{}: {} of {} stations are not captured and the pictures of {} not "
                  "imported, the first is {}; finish with run or import, or export the "
                  "finished part with --partial",
                  directory, planned, stations.size(), exposed, first->name));
}

// What a partial export leaves out.
std::string left_out(const std::vector<SessionStation>& stations,
                     const SessionVerification& verification) {
  const auto missing = std::ranges::count_if(stations, std::not_fn(is_captured));
  if (missing == 0) return "";
  std::string text =
      fmt::format("; left out: {} of {} stations, not captured yet", missing, stations.size());
  if (!verification.leftover.empty()) {
    text += fmt::format(" ({} files in frames/ belong to no captured station)",
                        verification.leftover.size());
  }
  return text;
}

// One of the two lists: the frames of the grid or the ground-truth views.
struct FrameTable {
  std::vector<ListedFrame> frames{};
  std::set<std::string> lines{};

  void add(const SessionFrame& frame, const SessionLine& line) {
    frames.push_back({.file = frame.file,
                      .position_m = {frame.position_m.x_m, 0.0, frame.position_m.z_m},
                      .line = line.validation ? "" : line.id});
    lines.insert(line.id);
  }
};

}  // namespace

std::string export_session(SessionReader* session, const ExportOptions& options) {
  const std::string directory = session->directory().string();
  const SessionFacts facts = session->facts();
  require_exposure(options.exposure, facts, directory);
  const SessionContents contents = session->contents();
  if (!options.partial) require_finished(contents.stations, directory);
  if (!options.unstitched) require_panoramas(contents.frames, facts, directory);
  const SessionVerification verification = verify_session(session);
  require_no_faults(verification.faults, session->directory());
  FrameTable grid, truth;
  for (const SessionFrame& frame : contents.frames) {
    if (frame.exposure != options.exposure) continue;
    const SessionLine& line = contents.line_of(contents.station_of(frame));
    (line.validation ? truth : grid).add(frame, line);
  }
  if (grid.frames.empty()) {
    throw Error(
        fmt::format("{}: no station of the grid is captured yet; there is nothing to "
                    "export",
                    directory));
  }
  const std::filesystem::path poses = session->directory() / "poses.csv";
  write_file_atomically(poses, frame_list_text(grid.frames));
  std::string summary = fmt::format("{}: {} frames on {} lines", poses.string(), grid.frames.size(),
                                    grid.lines.size());
  if (!truth.frames.empty()) {
    const std::filesystem::path views = session->directory() / "gt.csv";
    write_file_atomically(views, frame_list_text(truth.frames));
    summary += fmt::format("; {}: {} ground-truth views", views.string(), truth.frames.size());
  }
  return summary + left_out(contents.stations, verification);
}

}  // namespace raywalk::capture
