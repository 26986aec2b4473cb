#include "core/evaluate/held_out_views.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <system_error>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/evaluate/captured_station.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/shipped_configs.h"
#include "core/room/kept_stations.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

bool estimated(const Room& room) {
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    if (room.distances(line).maps() > 0 && !room.distances(line).given()) return true;
  }
  return false;
}

// The settings in depth.json that determine the distances.
struct DepthRun {
  std::string method{};
  int width = 0;
  int every = 0;
  int hold_out = 0;
  std::string valid_mask{};
  friend bool operator==(const DepthRun&, const DepthRun&) = default;
};

DepthRun read_depth_run(const fs::path& file) {
  const auto json = CheckedJson::read(file, "run raywalk-build-lf depth again");
  return {.method = json.at("method").text(),
          .width = json.at("width").integer(1),
          .every = json.has("every") ? json.at("every").integer(0) : 0,
          .hold_out = json.has("hold_out") ? json.at("hold_out").integer(0) : 0,
          .valid_mask = json.has("valid_mask") ? json.at("valid_mask").text() : ""};
}

// Whether the distances there were estimated with these settings, and after the room's own.
bool estimated_with(const fs::path& directory, const DepthRun& wanted, const fs::path& own) {
  std::error_code error;
  const fs::path report = directory / "depth.json";
  const fs::path distances = distances_directory(directory, DistanceKind::kEstimated);
  if (!fs::exists(report, error) || !fs::exists(distances, error)) return false;
  return fs::last_write_time(report) >= fs::last_write_time(own) &&
         read_depth_run(report) == wanted;
}

void estimate(const fs::path& room, const DepthRun& run) {
  std::vector<std::string> arguments{"depth",      room.string(),
                                     "--method",   run.method,
                                     "--width",    std::to_string(run.width),
                                     "--every",    std::to_string(run.every),
                                     "--hold-out", std::to_string(run.hold_out)};
  if (!run.valid_mask.empty()) arguments.insert(arguments.end(), {"--valid-mask", run.valid_mask});
  const fs::path program = program_folder() / "raywalk-build-lf";
  make_directories(held_out_directory(room));
  const fs::path log = held_out_directory(room) / "depth.log";
  spdlog::info("estimating distances without the held-out stations; see {}", log.string());
  ChildProcess depth(program, arguments, log);
  const int status = depth.wait();
  if (succeeded(status)) return;
  throw Error(fmt::format("{}: {} {}; see {}", room.string(), program.string(),
                          describe_failure(status), log.string()));
}

// A held-out station where a view can be rendered.
struct Candidate {
  int line = 0;
  int station = 0;
  std::string name{};
  PlanPoint viewpoint{};
};

// Not those on an overhang beyond the cells.
std::vector<Candidate> candidates_of(const Grid& grid, int every) {
  std::vector<Candidate> candidates;
  const auto held_out = held_out_stations(grid, every);
  for (size_t line = 0; line < held_out.size(); ++line) {
    for (const int index : held_out[line]) {
      const Station& station = grid.lines[line].stations[static_cast<size_t>(index)];
      const PlanPoint viewpoint{station.position_m.x(), station.position_m.z()};
      if (!grid.cells.empty() && !find_cell(grid, viewpoint)) continue;
      candidates.push_back(
          {static_cast<int>(line), index, fs::path(station.file).stem().string(), viewpoint});
    }
  }
  return candidates;
}

}  // namespace

Room room_without_held_out(const Room& room, int every) {
  if (every < 2) throw UsageError("--held-out must be at least 2: every n-th station is left out");
  Room part = room.subset(stations_except(room.grid(), held_out_stations(room.grid(), every)));
  if (!estimated(room)) return part;
  const fs::path own = room.directory() / "depth.json";
  DepthRun run = read_depth_run(own);
  run.hold_out = every;
  const fs::path directory = held_out_directory(room.directory());
  if (!estimated_with(directory, run, own)) estimate(room.directory(), run);
  return part.with_distances(distances_directory(directory, DistanceKind::kEstimated));
}

HeldOutViews held_out_views(const Room& room, int every, std::size_t most) {
  HeldOutViews held_out{room_without_held_out(room, every), {}};
  const std::vector<Candidate> candidates = candidates_of(room.grid(), every);
  if (candidates.empty()) {
    throw Error(
        fmt::format("{}: --held-out {} leaves out no station between the ends of its line; "
                    "give a smaller number, or true views with --truth",
                    room.directory().string(), every));
  }
  const std::size_t count = std::min(candidates.size(), most);
  for (std::size_t i = 0; i < count; ++i) {
    const Candidate& candidate = candidates[(2 * i + 1) * candidates.size() / (2 * count)];
    const LineVolume& volume = room.volume(candidate.line);
    held_out.views.push_back({.name = candidate.name,
                              .viewpoint = candidate.viewpoint,
                              .image = captured_picture(volume, candidate.station),
                              .mask = captured_mask(volume, candidate.station)});
  }
  return held_out;
}

}  // namespace raywalk
