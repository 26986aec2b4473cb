#include "core/evaluate/held_out.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstddef>
#include <opencv2/imgproc.hpp>
#include <system_error>

#include "core/base/child_process.h"
#include "core/base/error.h"
#include "core/base/pick_evenly.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/files/shipped_configs.h"
#include "core/room/kept_stations.h"
#include "core/room/station_image.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

bool estimated(const Room& room) {
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    if (room.distances(line).maps() > 0 && !room.distances(line).given()) return true;
  }
  return false;
}

// Of `raywalk-build-lf depth`: the settings in a depth.json that determine the distances, but with
// these stations left out.
std::vector<std::string> depth_arguments(const fs::path& file, int hold_out) {
  const auto json = CheckedJson::read(file, "run raywalk-build-lf depth again");
  const int every = json.has("every") ? json.at("every").integer(0) : 0;
  std::vector<std::string> arguments{"--method",   json.at("method").text(),
                                     "--width",    std::to_string(json.at("width").integer(1)),
                                     "--every",    std::to_string(every),
                                     "--hold-out", std::to_string(hold_out)};
  const std::string mask = json.has("valid_mask") ? json.at("valid_mask").text() : "";
  if (!mask.empty()) arguments.insert(arguments.end(), {"--valid-mask", mask});
  return arguments;
}

// Whether the distances there were estimated with these settings, and after the room's own.
bool estimated_with(const fs::path& directory, const std::vector<std::string>& wanted,
                    const fs::path& own) {
  std::error_code error;
  const fs::path report = directory / "depth.json";
  const fs::path distances = distances_directory(directory, DistanceKind::kEstimated);
  if (!fs::exists(report, error) || !fs::exists(distances, error)) return false;
  const auto json = CheckedJson::read(report, "run raywalk-build-lf depth again");
  return fs::last_write_time(report) >= fs::last_write_time(own) &&
         depth_arguments(report, json.has("hold_out") ? json.at("hold_out").integer(0) : 0) ==
             wanted;
}

void estimate(const fs::path& room, const std::vector<std::string>& settings) {
  std::vector<std::string> arguments{"depth", room.string()};
  arguments.insert(arguments.end(), settings.begin(), settings.end());
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

}  // namespace

std::vector<StationIndex> stations_with_views(const Grid& grid, const KeptStations& left_out) {
  std::vector<StationIndex> stations;
  for (std::size_t line = 0; line < left_out.size(); ++line) {
    for (const int index : left_out[line]) {
      const StationIndex station{static_cast<int>(line), index};
      const Eigen::Vector3d& at_m = grid.station(station).position_m;
      if (grid.cells.empty() || find_cell(grid, {at_m.x(), at_m.z()})) stations.push_back(station);
    }
  }
  return stations;
}

TrueView true_view_of(const Room& room, StationIndex station) {
  const LineVolume& volume = room.volume(station.line);
  const Station& captured = room.grid().station(station);
  TrueView view;
  view.name = fs::path(captured.file).stem().string();
  view.viewpoint = {captured.position_m.x(), captured.position_m.z()};
  view.height_m = captured.position_m.y();
  view.width = volume.panorama().width;
  if (volume.masked()) view.mask = captured_validity(volume, station.station).t();
  cv::cvtColor(captured_columns(volume, station.station).t(), view.image, cv::COLOR_RGB2BGR);
  return view;
}

Room room_without_held_out(const Room& room, int every) {
  if (every < 2) throw UsageError("--held-out must be at least 2: every n-th station is left out");
  Room part = room.subset(stations_except(room.grid(), held_out_stations(room.grid(), every)));
  if (!estimated(room)) return part;
  const fs::path own = room.directory() / "depth.json";
  const std::vector<std::string> settings = depth_arguments(own, every);
  const fs::path directory = held_out_directory(room.directory());
  if (!estimated_with(directory, settings, own)) estimate(room.directory(), settings);
  return part.with_distances(distances_directory(directory, DistanceKind::kEstimated));
}

HeldOutViews held_out_views(const Room& room, int every, std::size_t most) {
  HeldOutViews held_out{room_without_held_out(room, every), {}};
  const std::vector<StationIndex> stations =
      stations_with_views(room.grid(), held_out_stations(room.grid(), every));
  if (stations.empty()) {
    throw Error(
        fmt::format("{}: --held-out {} leaves out no station between the ends of its line; "
                    "give a smaller number, or true views with --truth",
                    room.directory().string(), every));
  }
  for (const int i : pick_evenly(static_cast<int>(stations.size()), static_cast<int>(most))) {
    held_out.views.push_back(true_view_of(room, stations[static_cast<std::size_t>(i)]));
  }
  return held_out;
}

}  // namespace raywalk
