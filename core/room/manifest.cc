// Writes and reads manifest.json; manifest_from_json in room.h lists what reading rejects.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/json.h"
#include "core/geometry/position_tolerance.h"
#include "core/room/room.h"

namespace raywalk {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "raywalk-room";
constexpr const char* kFrame =
    "metres; x right, y up, z forward (left-handed); theta = 0 looks to +z and grows towards +x, "
    "phi grows upwards; pixel (u, v): theta = (u + 0.5) / width * 360 - 180 degrees, phi = 90 - (v "
    "+ 0.5) / height * 180 degrees; every packed panorama is in world axes";
constexpr const char* kSideNames[] = {"front", "right", "back", "left"};

constexpr int kMaxWidth = 1 << 17;  // pixels; far beyond any camera
constexpr double kMaxMetres = 1e6;  // far beyond any room; keeps products finite
// Written values have full double precision; the tolerances allow for text edited by hand.
constexpr double kUnitTolerance = 1e-6;
constexpr double kAlongTolerance = 1e-6;     // metres, and of the distance along the line
constexpr double kCellSideTolerance = 0.01;  // of the cell's size; sides may be oblique

Json json_of(const Line& line, const std::string& sha256) {
  Json stations = Json::array();
  for (const Station& station : line.stations) {
    const Eigen::Vector3d& p = station.position_m;
    stations.push_back({{"file", station.file},
                        {"position_m", {p.x(), p.y(), p.z()}},
                        {"along_m", station.along_m}});
  }
  Json json = {{"id", line.id},
               {"axis", name_of(line.axis)},
               {"origin_m", {line.origin.x_m, line.origin.z_m}},
               {"direction", {line.direction.x_m, line.direction.z_m}},
               {"height_m", line.height_m}};
  if (!sha256.empty()) json["rays_sha256"] = sha256;
  json["stations"] = std::move(stations);
  return json;
}

Json json_of(const Cell& cell, const std::vector<Line>& lines) {
  Json json = {{"x_min_m", cell.x_min_m},
               {"x_max_m", cell.x_max_m},
               {"z_min_m", cell.z_min_m},
               {"z_max_m", cell.z_max_m}};
  for (size_t side = 0; side < cell.line.size(); ++side) {
    json[kSideNames[side]] = lines[static_cast<size_t>(cell.line[side])].id;
  }
  return json;
}

double metres(const CheckedJson& json) { return json.number(-kMaxMetres, kMaxMetres); }

PlanPoint plan_point(const CheckedJson& json) {
  const std::vector<CheckedJson> both = json.items(2);
  return {metres(both[0]), metres(both[1])};
}

void check_format(const CheckedJson& root) {
  const CheckedJson format = root.at("format");
  if (format.text() != kFormat) format.fail("is not " + std::string(kFormat));
  root.require_version(kRoomFormatVersion);
  const CheckedJson version = root.at("format_version");
  if (version.integer() < kRoomFormatVersion) version.fail("is older; pack the room again");
}

PanoramaSize read_panorama_size(const CheckedJson& json) {
  const PanoramaSize size{json.at("width").integer(2, kMaxWidth),
                          json.at("height").integer(1, kMaxWidth)};
  if (size.width != 2 * size.height) json.fail("the width is not twice the height");
  return size;
}

// A line's id is also its file name: "x" or "z" and a number.
std::string read_line_id(const CheckedJson& json, LineAxis axis) {
  std::string id = json.text();
  const bool number =
      id.size() > 1 && id.size() < 10 && id.find_first_not_of("0123456789", 1) == std::string::npos;
  if (!number || id[0] != (axis == LineAxis::kX ? 'x' : 'z')) {
    json.fail("is not the line's axis followed by a number, such as x0");
  }
  return id;
}

PlanPoint read_direction(const CheckedJson& json, LineAxis axis) {
  const PlanPoint direction = plan_point(json);
  const double along_axis = axis == LineAxis::kX ? direction.x_m : direction.z_m;
  if (std::abs(std::hypot(direction.x_m, direction.z_m) - 1.0) > kUnitTolerance) {
    json.fail("is not a unit vector");
  }
  // Above 45 degrees it would be a line along the other axis.
  if (along_axis < std::sqrt(0.5)) json.fail("does not follow the line's axis");
  return direction;
}

Station read_station(const CheckedJson& json, const Line& line) {
  Station station;
  station.file = json.at("file").text();
  if (station.file.empty()) json.at("file").fail("is empty");
  const std::vector<CheckedJson> position = json.at("position_m").items(3);
  station.position_m = {metres(position[0]), metres(position[1]), metres(position[2])};
  station.along_m = metres(json.at("along_m"));
  const PlanPoint plan{station.position_m.x(), station.position_m.z()};
  const double tolerance_m =
      kAlongTolerance * (1.0 + std::abs(station.along_m)) +
      rounding_m(largest_coordinate_m(plan) + largest_coordinate_m(line.origin));
  if (std::abs(along_line(line, plan) - station.along_m) > tolerance_m) {
    json.fail("along_m contradicts position_m");
  }
  if (!line.stations.empty() && station.along_m <= line.stations.back().along_m) {
    json.fail("along_m does not increase");
  }
  return station;
}

Line read_line(const CheckedJson& json) {
  Line line;
  const std::string axis = json.at("axis").text();
  if (axis != "x" && axis != "z") json.at("axis").fail("is neither x nor z");
  line.axis = axis == "x" ? LineAxis::kX : LineAxis::kZ;
  line.id = read_line_id(json.at("id"), line.axis);
  line.origin = plan_point(json.at("origin_m"));
  line.direction = read_direction(json.at("direction"), line.axis);
  line.height_m = metres(json.at("height_m"));
  for (const CheckedJson& station : json.at("stations").items()) {
    line.stations.push_back(read_station(station, line));
  }
  if (line.stations.size() < 2) json.fail("has fewer than two stations");
  return line;
}

std::string read_sha256(const CheckedJson& json) {
  std::string sha256 = json.text();
  if (sha256.size() != 64 || sha256.find_first_not_of("0123456789abcdef") != std::string::npos) {
    json.fail("is not a SHA-256 checksum");
  }
  return sha256;
}

void read_lines(const CheckedJson& json, RoomManifest* manifest) {
  std::set<std::string> ids;
  for (const CheckedJson& item : json.items()) {
    manifest->grid.lines.push_back(read_line(item));
    if (!ids.insert(manifest->grid.lines.back().id).second) {
      item.fail(fmt::format("the id {} occurs twice", manifest->grid.lines.back().id));
    }
    if (item.has("rays_sha256")) {
      manifest->rays_sha256.push_back(read_sha256(item.at("rays_sha256")));
    }
  }
  if (manifest->grid.lines.empty()) json.fail("is empty");
  if (!manifest->rays_sha256.empty() && manifest->rays_sha256.size() != ids.size()) {
    json.fail("some lines have a rays_sha256 and others have none");
  }
}

RefinedRecord read_refined(const CheckedJson& json) {
  constexpr double kMostSharpening = 2.0;
  RefinedRecord record{.source = json.at("source").text(),
                       .source_fingerprint = json.at("source_fingerprint").text(),
                       .source_stations = json.at("source_stations").integer(1),
                       .hold_out = json.at("hold_out").integer(0)};
  const auto sharpening = json.at("sharpening").items(2);
  for (std::size_t i = 0; i < 2; ++i) {
    record.sharpening[i] = sharpening[i].number(0.0, kMostSharpening);
  }
  return record;
}

// Each side must lie on the cell's bounds; checked at the middle of the side.
void check_side(const CheckedJson& json, const Line& line, const Cell& cell, Side side) {
  const bool along_x = side == Side::kFront || side == Side::kBack;
  if ((line.axis == LineAxis::kX) != along_x) json.fail("runs along the wrong axis");
  const double x = 0.5 * (cell.x_min_m + cell.x_max_m), z = 0.5 * (cell.z_min_m + cell.z_max_m);
  const PlanPoint& d = line.direction;
  const double at = along_x ? line.origin.z_m + (x - line.origin.x_m) * d.z_m / d.x_m
                            : line.origin.x_m + (z - line.origin.z_m) * d.x_m / d.z_m;
  const std::array<double, 4> bounds{cell.z_max_m, cell.x_max_m, cell.z_min_m, cell.x_min_m};
  const double size = std::max(cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m);
  if (std::abs(at - bounds[static_cast<size_t>(side)]) > kCellSideTolerance * size) {
    json.fail("the line does not lie where the cell's bounds say");
  }
}

Cell read_cell(const CheckedJson& json, const std::vector<Line>& lines) {
  Cell cell;
  cell.x_min_m = metres(json.at("x_min_m"));
  cell.x_max_m = metres(json.at("x_max_m"));
  cell.z_min_m = metres(json.at("z_min_m"));
  cell.z_max_m = metres(json.at("z_max_m"));
  if (!(cell.x_min_m < cell.x_max_m && cell.z_min_m < cell.z_max_m)) json.fail("has no area");
  for (size_t side = 0; side < cell.line.size(); ++side) {
    const CheckedJson item = json.at(kSideNames[side]);
    const std::string id = item.text();
    const auto found =
        std::find_if(lines.begin(), lines.end(), [&](const Line& line) { return line.id == id; });
    if (found == lines.end()) item.fail("names a line that does not exist");
    cell.line[side] = static_cast<int>(found - lines.begin());
    check_side(item, *found, cell, static_cast<Side>(side));
  }
  return cell;
}

}  // namespace

std::string name_of(DistanceKind kind) {
  constexpr std::array kNames{"none", "given", "estimated"};
  return kNames[static_cast<size_t>(kind)];
}

std::string manifest_to_json(const RoomManifest& manifest) {
  Json lines = Json::array();
  for (size_t i = 0; i < manifest.grid.lines.size(); ++i) {
    lines.push_back(json_of(manifest.grid.lines[i],
                            manifest.rays_sha256.empty() ? "" : manifest.rays_sha256[i]));
  }
  Json cells = Json::array();
  for (const Cell& cell : manifest.grid.cells) cells.push_back(json_of(cell, manifest.grid.lines));
  Json root = {
      {"format", kFormat},
      {"format_version", kRoomFormatVersion},
      {"written_by", "raywalk " RAYWALK_VERSION},
      {"frame", kFrame},
      {"panorama", {{"width", manifest.panorama.width}, {"height", manifest.panorama.height}}},
      {"lines", std::move(lines)},
      {"cells", std::move(cells)}};
  root["distances"] = name_of(manifest.distances);
  root["gains"] = manifest.gains;
  if (manifest.refined) {
    root["refined"] = {{"source", manifest.refined->source.string()},
                       {"source_fingerprint", manifest.refined->source_fingerprint},
                       {"source_stations", manifest.refined->source_stations},
                       {"hold_out", manifest.refined->hold_out},
                       {"sharpening", manifest.refined->sharpening}};
  }
  try {
    return root.dump(1) + "\n";
  } catch (const nlohmann::json::exception&) {
    throw Error(
        "a frame's file name is not UTF-8, which the manifest cannot hold; rename the file");
  }
}

RoomManifest manifest_from_json(const std::string& text, const std::string& source) {
  const CheckedJson root = CheckedJson::parse(text, source);
  check_format(root);
  RoomManifest manifest;
  manifest.panorama = read_panorama_size(root.at("panorama"));
  read_lines(root.at("lines"), &manifest);
  for (const CheckedJson& cell : root.at("cells").items()) {
    manifest.grid.cells.push_back(read_cell(cell, manifest.grid.lines));
  }
  const CheckedJson distances = root.at("distances");
  const auto kind = std::ranges::find(kDistanceKinds, distances.text(),
                                      [](DistanceKind each) { return name_of(each); });
  if (kind == kDistanceKinds.end()) distances.fail("is not none, given or estimated");
  manifest.distances = *kind;
  manifest.gains = root.at("gains").boolean();
  if (root.has("refined")) manifest.refined = read_refined(root.at("refined"));
  return manifest;
}

}  // namespace raywalk
