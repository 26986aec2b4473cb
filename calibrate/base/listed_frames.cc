#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <map>

#include "calibrate/base/frame_readers.h"
#include "core/base/error.h"
#include "core/files/frame_list.h"
#include "core/geometry/line_gaps.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

std::vector<StationPose> stations_of(const std::vector<Frame>& frames) {
  std::vector<StationPose> stations;
  stations.reserve(frames.size());
  for (const Frame& frame : frames) {
    stations.push_back({frame.file, frame.position_m, frame.where, frame.line});
  }
  return stations;
}

double mean_across(const Line& line) {
  double sum_m = 0.0;
  for (const Station& station : line.stations) {
    sum_m += line.axis == LineAxis::kX ? station.position_m.z() : station.position_m.x();
  }
  return sum_m / static_cast<double>(line.stations.size());
}

// The same for different spellings of one file, and for links to it.
std::string identity_of(const fs::path& file) {
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(file, error);
  return (error ? file.lexically_normal() : canonical).string();
}

void require_listed_once(const std::vector<Frame>& stations, const std::vector<Frame>& held_out) {
  std::map<std::string, std::string> listed;  // file -> where
  for (const Frame& frame : stations) listed.emplace(identity_of(frame.path), frame.where);
  for (const Frame& frame : held_out) {
    const auto [first, is_new] = listed.emplace(identity_of(frame.path), frame.where);
    if (is_new) continue;
    throw Error(fmt::format(
        "{}: {} is already listed at {}; a frame is either a station or held out: remove one row",
        frame.where, frame.file, first->second));
  }
}

CaptureFrame captured(const Frame& listed, const std::string& name, int line) {
  return {.name = name,
          .line = line,
          .file = listed.path,
          .nominal_m = listed.position_m,
          .nominal_attitude = listed.attitude,
          .mask = listed.mask,
          .where = listed.where};
}

std::vector<std::string> files_of(const std::vector<Frame>& frames) {
  std::vector<std::string> files;
  files.reserve(frames.size());
  for (const Frame& frame : frames) files.push_back(frame.file);
  return files;
}

void add_held_out(const fs::path& list, const std::vector<Frame>& stations,
                  const std::vector<std::string>& names_of_stations, CaptureSet* set) {
  // Also a link to nowhere is a list, one that cannot be read.
  if (!fs::exists(fs::symlink_status(list))) return;
  const std::vector<Frame> listed = read_frame_list(list, {"distance"});
  require_listed_once(stations, listed);
  // Unlike those of the stations, which do not depend on gt.csv.
  const std::vector<std::string> names = frame_names(files_of(listed), list, names_of_stations);
  for (std::size_t row = 0; row < listed.size(); ++row) {
    set->frames.push_back(captured(listed[row], names[row], kHeldOut));
  }
}

}  // namespace

fs::path frame_list_of(const fs::path& directory) { return directory / "poses.csv"; }

CaptureSet read_listed_frames(const CaptureInput& input) {
  const fs::path list = frame_list_of(input.directory);
  const std::vector<Frame> listed = read_frame_list(list);
  const Grid grid = find_grid(stations_of(listed), input.tolerance);
  if (const auto doubt = doubt_of_unit(grid)) spdlog::warn("{}: {}", list.string(), *doubt);
  for (const std::string& note : line_notes(grid)) spdlog::warn("{}: {}", list.string(), note);
  std::map<std::string, std::size_t> row_of;
  for (std::size_t row = 0; row < listed.size(); ++row) row_of[listed[row].file] = row;
  const std::vector<std::string> names = frame_names(files_of(listed), list);
  CaptureSet set;
  set.source = input.directory;
  set.layout = input.dual_fisheye ? FrameLayout::kDualFisheye : FrameLayout::kPanorama;
  for (const Line& line : grid.lines) {
    const int line_index = static_cast<int>(set.lines.size());
    set.lines.push_back({.id = line.id, .axis = line.axis, .across_m = mean_across(line)});
    for (const Station& station : line.stations) {
      const std::size_t row = row_of.at(station.file);
      set.frames.push_back(captured(listed[row], names[row], line_index));
    }
  }
  add_held_out(input.directory / "gt.csv", listed, names, &set);
  return set;
}

}  // namespace raywalk::calibrate
