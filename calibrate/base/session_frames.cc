#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "calibrate/base/frame_readers.h"
#include "core/base/error.h"
#include "core/files/frame_list.h"
#include "core/session/session_contents.h"
#include "core/session/session_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

FrameLayout layout_of(const SessionContents& session, const CaptureInput& input) {
  if (input.exposure < 0 || input.exposure >= session.exposures) {
    throw UsageError(
        fmt::format("{}: has {} exposure(s) of every station; --exposure must be 0 to {}",
                    input.directory.string(), session.exposures, session.exposures - 1));
  }
  if (session.frame_kind == "panorama") return FrameLayout::kPanorama;
  if (session.frame_kind == "dual-fisheye") return FrameLayout::kDualFisheye;
  throw_damaged_session(input.directory, "frames of the session is " + excerpt(session.frame_kind) +
                                             "; it must be panorama or dual-fisheye");
}

// The placements of the rail: a line that is longer than the rail has several, each with errors of
// its own.
struct Placements {
  std::vector<CaptureLine> rails{};
  std::vector<int> of_station{};  // index into rails, for every station of the session
};

// A new placement begins where the planned position on the rail does not increase along the line.
// The first has the id of the line, "x0", further ones "x0-2", "x0-3", ...
Placements placements_of(const SessionContents& session) {
  Placements placements;
  int line_before = -1, number = 0;
  double before_mm = 0.0;
  for (const SessionStation& station : session.stations) {
    const bool is_new_line = station.line != line_before;
    if (is_new_line || station.planned_mm <= before_mm) {
      const SessionLine& line = session.line_of(station);
      number = is_new_line ? 1 : number + 1;
      placements.rails.push_back(
          {.id = number == 1 ? line.id : fmt::format("{}-{}", line.id, number),
           .axis = line.axis,
           .across_m = line.across_m,
           .validation = line.validation});
    }
    placements.of_station.push_back(static_cast<int>(placements.rails.size()) - 1);
    line_before = station.line;
    before_mm = station.planned_mm;
  }
  return placements;
}

void require_file(const SessionContents& session, const SessionFrame& frame) {
  std::string fault = file_fault(session, frame);
  if (fault.empty()) return;
  require_no_faults({{session.station_of(frame).name, std::move(fault)}}, session.directory);
}

// The pictures of one station at the requested exposure.
struct StationPictures {
  const SessionFrame* first = nullptr;  // of both lenses or the front one
  const SessionFrame* back = nullptr;
};

CaptureFrame frame_of(const SessionContents& session, const StationPictures& pictures, int rail) {
  const SessionFrame& first = *pictures.first;
  const SessionStation& station = session.station_of(first);
  CaptureFrame frame{.name = station.name,
                     .line = rail,
                     .file = session.directory / first.file,
                     .nominal_m = {first.position_m.x_m, 0.0, first.position_m.z_m},
                     .sha256 = first.sha256};
  if (pictures.back != nullptr) {
    frame.back = session.directory / pictures.back->file;
    frame.sha256 += pictures.back->sha256;
  }
  return frame;
}

// One frame per captured station, along each placement by the feedback.
std::vector<CaptureFrame> frames_of(const SessionContents& session, const Placements& placements,
                                    int exposure) {
  std::map<int, StationPictures> stations;
  for (const SessionFrame& frame : session.frames) {
    if (frame.exposure != exposure) continue;
    require_file(session, frame);
    StationPictures& pictures = stations[frame.station];
    (frame.lens == FrameLens::kBack ? pictures.back : pictures.first) = &frame;
  }
  std::vector<CaptureFrame> frames;
  for (const auto& [station, pictures] : stations) {
    if (pictures.first == nullptr) {
      throw Error(fmt::format(
          "{}: station {} has only the back lens's picture; import the front one, "
          "or remove the station",
          session.directory.string(), session.stations[static_cast<std::size_t>(station)].name));
    }
    frames.push_back(
        frame_of(session, pictures, placements.of_station[static_cast<std::size_t>(station)]));
  }
  const auto along_m = [&](const CaptureFrame& frame) {
    const LineAxis axis = placements.rails[static_cast<std::size_t>(frame.line)].axis;
    return axis == LineAxis::kX ? frame.nominal_m.x() : frame.nominal_m.z();
  };
  std::stable_sort(frames.begin(), frames.end(), [&](const CaptureFrame& a, const CaptureFrame& b) {
    return a.line == b.line ? along_m(a) < along_m(b) : a.line < b.line;
  });
  return frames;
}

// The frames of a line are in the order of their places.
void require_distinct_places(const CaptureSet& set) {
  constexpr double kSamePlace_m = 1e-6;  // finer than any slider's feedback
  for (std::size_t i = 1; i < set.frames.size(); ++i) {
    const CaptureFrame &one = set.frames[i - 1], &next = set.frames[i];
    const auto at = static_cast<int>(i);
    if (one.line != next.line || set.rail_m(at) - set.rail_m(at - 1) > kSamePlace_m) continue;
    throw_damaged_session(
        set.source,
        fmt::format("stations {} and {} are at the same place of their line, {} = {:g} m", one.name,
                    next.name, name_of(set.lines[static_cast<std::size_t>(one.line)].axis),
                    set.rail_m(at)));
  }
}

void require_every_station(const SessionContents& session, const CaptureInput& input,
                           const CaptureSet& set) {
  if (session.stations.empty()) {
    throw Error(fmt::format(
        "{}: plans no stations, so there is nothing to calibrate; give another session, or restore "
        "this one from a copy",
        session_database_path(input.directory).string()));
  }
  const std::size_t stations = session.stations.size(), captured = set.frames.size();
  if (captured > 0 && (captured == stations || input.partial)) return;
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

// A session's folder may hold its own export, poses.csv, which is not read here. A list of other
// frames would be a second capture in the same folder.
void require_no_other_list(const SessionContents& session) {
  const fs::path list = frame_list_of(session.directory);
  if (!fs::exists(list)) return;
  std::set<std::string> files;
  for (const SessionFrame& frame : session.frames) files.insert(frame.file);
  for (const Frame& frame : read_frame_list(list)) {
    if (files.contains(fs::path(frame.file).lexically_normal().string())) continue;
    throw Error(fmt::format(
        "{}: holds a capture session, and a poses.csv with a frame that is not the session's ({}); "
        "move poses.csv and its frames to a folder of their own, or, if it is an old export, give "
        "raywalk-capture export again",
        session.directory.string(), excerpt(frame.file)));
  }
  spdlog::info("{}: uses the session; its poses.csv, an export of it, is not read",
               session.directory.string());
}

}  // namespace

CaptureSet read_session_frames(const CaptureInput& input) {
  SqliteConnection database = open_session_to_read(input.directory);
  const SessionContents session = read_session_contents(&database, input.directory);
  require_no_other_list(session);
  CaptureSet set;
  set.source = input.directory;
  set.layout = layout_of(session, input);
  Placements placements = placements_of(session);
  set.frames = frames_of(session, placements, input.exposure);
  set.lines = std::move(placements.rails);
  require_every_station(session, input, set);
  require_distinct_places(set);
  require_both_halves(set);
  return set;
}

}  // namespace raywalk::calibrate
