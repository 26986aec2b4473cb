#include "calibrate/base/listed_frames.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/files/frame_list.h"
#include "core/geometry/plausible_size.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Names are parts of file names and JSON, so they are escaped.
std::string stem_of(const std::string& file) { return escaped(fs::path(file).stem().string()); }

std::string joined_path_of(const std::string& file) {
  std::string name = fs::path(file).replace_extension().generic_string();
  std::replace(name.begin(), name.end(), '/', '_');
  return escaped(name);
}

template <typename NameOf>
std::vector<std::string> names_by(std::span<const std::string> files, const NameOf& name_of) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const std::string& file : files) names.push_back(name_of(file));
  return names;
}

bool are_unique(const std::vector<std::string>& names) {
  return std::set<std::string>(names.begin(), names.end()).size() == names.size();
}

std::vector<StationPose> stations_of(const std::vector<Frame>& frames) {
  std::vector<StationPose> stations;
  stations.reserve(frames.size());
  for (const Frame& frame : frames) {
    stations.push_back({.file = frame.file, .position_m = frame.position_m, .where = frame.where});
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

}  // namespace

fs::path frame_list_of(const fs::path& directory) { return directory / "poses.csv"; }

std::vector<std::string> frame_names(std::span<const std::string> files, const fs::path& list) {
  std::vector<std::string> names = names_by(files, stem_of);
  if (!are_unique(names)) names = names_by(files, joined_path_of);
  if (!are_unique(names)) {
    throw Error(list.string() +
                ": two of its files differ only in their extension; list one of them");
  }
  return names;
}

CaptureSet read_listed_frames(const CaptureInput& input) {
  const fs::path list = frame_list_of(input.directory);
  const std::vector<Frame> listed = read_frame_list(list);
  GridTolerance tolerance;
  if (input.line_tolerance_mm) tolerance.off_line_m = *input.line_tolerance_mm / 1000.0;
  const Grid grid = find_grid(stations_of(listed), tolerance);
  if (const auto doubt = doubt_of_unit(grid)) spdlog::warn("{}: {}", list.string(), *doubt);
  std::vector<std::string> files;
  std::map<std::string, std::size_t> row_of;
  for (std::size_t row = 0; row < listed.size(); ++row) {
    files.push_back(listed[row].file);
    row_of[listed[row].file] = row;
  }
  const std::vector<std::string> names = frame_names(files, list);
  CaptureSet set;
  set.source = input.directory;
  set.layout = input.dual_fisheye ? FrameLayout::kDualFisheye : FrameLayout::kPanorama;
  for (const Line& line : grid.lines) {
    const int line_index = static_cast<int>(set.lines.size());
    set.lines.push_back({.id = line.id, .axis = line.axis, .across_m = mean_across(line)});
    for (const Station& station : line.stations) {
      const std::size_t row = row_of.at(station.file);
      set.frames.push_back({.name = names[row],
                            .line = line_index,
                            .file = listed[row].path,
                            .nominal_m = listed[row].position_m,
                            .nominal_attitude = listed[row].attitude});
    }
  }
  return set;
}

}  // namespace raywalk::calibrate
