#include "build_lf/quality/room_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <system_error>

#include "build_lf/pack/distance_sets.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/json.h"
#include "core/geometry/line_gaps.h"
#include "core/room/refined_record.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::uintmax_t bytes_of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  return error ? 0 : bytes;
}

// The forms in which the lines are stored, each once.
std::string compression_of(const std::vector<LineInfo>& lines) {
  std::vector<std::string> forms;
  for (const LineInfo& line : lines) {
    const std::string form = name_of(line.form);
    if (std::ranges::find(forms, form) == forms.end()) forms.push_back(form);
  }
  return fmt::format("{}", fmt::join(forms, " and "));
}

// Sets the overhang of a line beyond the outermost of the cell corners on it.
void set_overhang(const Grid& grid, int index, LineInfo* info) {
  const Line& line = grid.lines[static_cast<size_t>(index)];
  std::optional<double> first, last;
  for (const Cell& cell : grid.cells) {
    if (std::find(cell.line.begin(), cell.line.end(), index) == cell.line.end()) continue;
    for (int other : cell.line) {
      const Line& across = grid.lines[static_cast<size_t>(other)];
      if (across.axis == line.axis) continue;
      const double corner = along_line(line, intersection_of(line, across));
      first = std::min(first.value_or(corner), corner);
      last = std::max(last.value_or(corner), corner);
    }
  }
  if (!first) return;
  info->overhang_first_m = *first - line.first_m();
  info->overhang_last_m = line.last_m() - *last;
}

// Where a line is, and how far apart its stations are.
void set_places(const Line& line, LineInfo* info) {
  const bool along_x = line.axis == LineAxis::kX;
  const auto at = [&](double along, bool x) {
    return x ? line.origin.x_m + along * line.direction.x_m
             : line.origin.z_m + along * line.direction.z_m;
  };
  info->from_m = at(line.first_m(), along_x);
  info->to_m = at(line.last_m(), along_x);
  info->place_m = at(0.5 * (line.first_m() + line.last_m()), !along_x);
  info->oblique_deg =
      degrees_from_radians(along_x ? std::atan2(line.direction.z_m, line.direction.x_m)
                                   : std::atan2(line.direction.x_m, line.direction.z_m));
  info->spacing_median_m = median_spacing_m(line);
  info->spacing_min_m = info->spacing_max_m = info->spacing_median_m;
  for (size_t i = 1; i < line.stations.size(); ++i) {
    const double spacing = line.stations[i].along_m - line.stations[i - 1].along_m;
    info->spacing_min_m = std::min(info->spacing_min_m, spacing);
    info->spacing_max_m = std::max(info->spacing_max_m, spacing);
  }
}

// Rows [begin, end) of a column cover the share (sin phi_begin - sin phi_end) / 2 of its solid
// angle.
double masked_share_of(const LineVolume& volume, Progress* progress) {
  if (!volume.masked()) {
    progress->advance(volume.stations());
    return 0.0;
  }
  const auto [width, height] = volume.panorama();
  double valid = 0.0;
  for (int station = 0; station < volume.stations(); ++station) {
    for (int theta = 0; theta < width; ++theta) {
      const RowRun run = volume.valid_rows(station, theta);
      if (run.empty()) continue;
      valid += 0.5 * (std::cos(kPi * run.begin / height) - std::cos(kPi * run.end / height));
    }
    progress->advance();
  }
  return 1.0 - valid / (static_cast<double>(volume.stations()) * width);
}

LineInfo line_info(const Room& room, int index, Progress* progress) {
  const Line& line = room.grid().lines[static_cast<size_t>(index)];
  LineInfo info;
  info.id = line.id;
  info.axis = line.axis;
  info.stations = static_cast<int>(line.stations.size());
  set_places(line, &info);
  set_overhang(room.grid(), index, &info);
  info.masked_share = masked_share_of(room.volume(index), progress);
  info.distance_maps = room.distances(index).maps();
  info.distance_size = room.distances(index).size();
  info.form = room.volume(index).form();
  info.bytes = bytes_of(line_volume_path(room.directory(), line.id)) +
               bytes_of(distance_volume_path(room.directory(), line.id, room.manifest().distances));
  return info;
}

// Which distances views use, and how to use others.
std::string use_text(const RoomInfo& info, const std::string& name) {
  std::string text = "distances in use: " + info.distances + "\n";
  for (const FoundDistances& found : info.found) {
    if (!found.fault.empty()) {
      text += "not usable: " + found.fault + "\n";
    } else if (!found.in_use) {
      text += fmt::format("not in use: {} (`raywalk-build-lf distances {} --use {}`)\n",
                          found.origin, shell_word(name), name_of(found.kind));
    }
  }
  return text;
}

std::string distances_text(const LineInfo& line) {
  if (line.distance_maps == 0) return "none";
  return fmt::format("{} of {}, {} x {}", line.distance_maps, line.stations,
                     line.distance_size.width, line.distance_size.height);
}

std::string overhang_text(const LineInfo& line) {
  if (!line.overhang_first_m) return "-";
  return fmt::format("{:.3f} / {:.3f}", *line.overhang_first_m, *line.overhang_last_m);
}

std::string masked_text(const LineInfo& line) {
  return line.masked_share > 0.0 ? fmt::format("{:.2f} %", 100.0 * line.masked_share) : "-";
}

Json json_of_line(const LineInfo& line) {
  const auto or_null = [](std::optional<double> value) { return value ? Json(*value) : Json(); };
  return {{"id", line.id},
          {"axis", line.axis == LineAxis::kX ? "x" : "z"},
          {"stations", line.stations},
          {"place_m", line.place_m},
          {"from_m", line.from_m},
          {"to_m", line.to_m},
          {"oblique_deg", line.oblique_deg},
          {"spacing_min_m", line.spacing_min_m},
          {"spacing_median_m", line.spacing_median_m},
          {"spacing_max_m", line.spacing_max_m},
          {"overhang_first_m", or_null(line.overhang_first_m)},
          {"overhang_last_m", or_null(line.overhang_last_m)},
          {"masked_share", line.masked_share},
          {"distance_maps", line.distance_maps},
          {"distance_width", line.distance_size.width},
          {"distance_height", line.distance_size.height},
          {"compression", name_of(line.form)},
          {"bytes", line.bytes}};
}

}  // namespace

RoomInfo info_of(const Room& room) {
  RoomInfo info;
  info.panorama = room.panorama();
  info.cells = room.grid().cells;
  info.bytes = bytes_of(manifest_path(room.directory()));
  info.stations = static_cast<int>(all_stations(room.grid()).size());
  Progress progress("reading", info.stations, "stations", Progress::Shown::kIfLong);
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    throw_if_interrupted();
    info.lines.push_back(line_info(room, line, &progress));
    info.masked_share += info.lines.back().masked_share * info.lines.back().stations;
    info.distance_maps += info.lines.back().distance_maps;
    info.bytes += info.lines.back().bytes;
  }
  info.masked_share /= info.stations;
  info.compression = compression_of(info.lines);
  info.distances = room.distances_origin();
  info.refined = refined_text(room);
  for (const auto& line : room.gains()) {
    info.stations_with_gains += static_cast<int>(std::ranges::count_if(line, std::not_fn(is_one)));
  }
  if (!room.gains().empty()) info.bytes += bytes_of(gains_path(room.directory()));
  info.found = find_distances(room.directory(), room.manifest());
  return info;
}

std::string summary_of(const RoomInfo& info, const std::string& name) {
  const std::string masked =
      info.masked_share > 0.0 ? fmt::format(", {:.2f} % masked", 100.0 * info.masked_share) : "";
  const std::string origin = info.distance_maps > 0 ? " (" + info.distances + ")" : "";
  const std::string form = info.compression == "none" ? "" : " (" + info.compression + ")";
  return fmt::format("{}: {}, {}, {} of {} x {}{}, {}{}, {:.1f} MB{}", name,
                     counted(info.lines.size(), "line"), counted(info.cells.size(), "cell"),
                     counted(static_cast<std::size_t>(info.stations), "panorama"),
                     info.panorama.width, info.panorama.height, masked,
                     counted(static_cast<std::size_t>(info.distance_maps), "distance map"), origin,
                     static_cast<double>(info.bytes) * 1e-6, form);
}

std::string text_of(const RoomInfo& info, const std::string& name) {
  std::string text = summary_of(info, name) + "\n" + use_text(info, name) + "\n";
  if (!info.refined.empty()) text += info.refined + "\n";
  if (info.stations_with_gains > 0) {
    text += fmt::format("views apply gains to {} of {}\n", info.stations_with_gains,
                        counted(static_cast<std::size_t>(info.stations), "station"));
  }
  text += fmt::format("{:<5} {:>8} {:>9} {:>19} {:>8}  {:>23}  {:>15} {:>8}  {:<22} {:>9}\n",
                      "line", "stations", "at m", "from .. to m", "oblique",
                      "spacing min/med/max m", "overhang m", "masked", "distance maps", "MB");
  for (const LineInfo& line : info.lines) {
    text += fmt::format(
        "{:<5} {:>8} {:>9.3f} {:>19} {:>8}  {:>23}  {:>15} {:>8}  {:<22} {:>9.1f}\n", line.id,
        line.stations, line.place_m, fmt::format("{:.3f} .. {:.3f}", line.from_m, line.to_m),
        fmt::format("{:.2f} deg", line.oblique_deg),
        fmt::format("{:.4f}/{:.4f}/{:.4f}", line.spacing_min_m, line.spacing_median_m,
                    line.spacing_max_m),
        overhang_text(line), masked_text(line), distances_text(line),
        static_cast<double>(line.bytes) * 1e-6);
  }
  text += info.cells.empty() ? "\nno cell is closed\n"
                             : "\ncell   x from .. to m        z from .. to m        "
                               "front right back  left\n";
  for (std::size_t i = 0; i < info.cells.size(); ++i) {
    const Cell& cell = info.cells[i];
    const auto id = [&](Side side) {
      return info.lines[static_cast<size_t>(cell.line[static_cast<size_t>(side)])].id;
    };
    text += fmt::format("{:<6} {:<21} {:<21} {:<5} {:<5} {:<5} {:<5}\n", i,
                        fmt::format("{:.3f} .. {:.3f}", cell.x_min_m, cell.x_max_m),
                        fmt::format("{:.3f} .. {:.3f}", cell.z_min_m, cell.z_max_m),
                        id(Side::kFront), id(Side::kRight), id(Side::kBack), id(Side::kLeft));
  }
  return text;
}

std::string json_of(const RoomInfo& info) {
  Json lines = Json::array();
  for (const LineInfo& line : info.lines) lines.push_back(json_of_line(line));
  Json cells = Json::array();
  for (const Cell& cell : info.cells) {
    Json sides = Json::array();
    for (int line : cell.line) sides.push_back(info.lines[static_cast<size_t>(line)].id);
    cells.push_back({{"x_min_m", cell.x_min_m},
                     {"x_max_m", cell.x_max_m},
                     {"z_min_m", cell.z_min_m},
                     {"z_max_m", cell.z_max_m},
                     {"front_right_back_left", std::move(sides)}});
  }
  Json sets = Json::array(), faults = Json::array();
  for (const FoundDistances& found : info.found) {
    if (found.fault.empty()) {
      sets.push_back({{"origin", found.origin},
                      {"directory", "distances/" + name_of(found.kind)},
                      {"in_use", found.in_use}});
    } else {
      faults.push_back(found.fault);
    }
  }
  const Json root = {
      {"panorama", {{"width", info.panorama.width}, {"height", info.panorama.height}}},
      {"stations", info.stations},
      {"masked_share", info.masked_share},
      {"distance_maps", info.distance_maps},
      {"distances", info.distances},
      {"distance_sets", std::move(sets)},
      {"distance_faults", std::move(faults)},
      {"stations_with_gains", info.stations_with_gains},
      {"compression", info.compression},
      {"refined", info.refined.empty() ? Json() : Json(info.refined)},
      {"bytes", info.bytes},
      {"lines", std::move(lines)},
      {"cells", std::move(cells)}};
  return json_text(root);
}

}  // namespace raywalk::build_lf
