// Writes and reads manifest.json; manifest_from_json in room.h lists what reading rejects.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
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

constexpr int kMaxDepth = 16;       // the manifest itself nests 5 deep
constexpr int kMaxWidth = 1 << 17;  // pixels; far beyond any camera
constexpr double kMaxMetres = 1e6;  // far beyond any room; keeps products finite
// Written values have full double precision; the tolerances allow for text edited by hand.
constexpr double kUnitTolerance = 1e-6;
constexpr double kAlongTolerance = 1e-6;     // of the coordinates' size
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
               {"axis", line.axis == LineAxis::kX ? "x" : "z"},
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

// A JSON value with its path, for error messages.
class Reader {
 public:
  Reader(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(one_line(fmt::format("{}: {}", place_, what)));
  }

  Reader at(const std::string& key) const {
    if (!json_.is_object()) fail("is not an object");
    const auto found = json_.find(key);
    if (found == json_.end()) fail(fmt::format("has no '{}'", key));
    return {*found, fmt::format("{}: {}", place_, key)};
  }
  bool has(const std::string& key) const { return json_.is_object() && json_.contains(key); }

  std::vector<Reader> items() const {
    if (!json_.is_array()) fail("is not a list");
    std::vector<Reader> readers;
    for (size_t i = 0; i < json_.size(); ++i) {
      readers.emplace_back(json_[i], fmt::format("{}[{}]", place_, i));
    }
    return readers;
  }
  std::vector<Reader> items(size_t count) const {
    std::vector<Reader> readers = items();
    if (readers.size() != count) fail(fmt::format("does not have {} elements", count));
    return readers;
  }

  std::string text() const {
    if (!json_.is_string()) fail("is not a string");
    std::string value = json_.get<std::string>();
    if (value.empty()) fail("is empty");
    return value;
  }
  int integer(int min, int max) const {
    if (!json_.is_number_integer()) fail("is not an integer");
    const bool too_large =
        json_.is_number_unsigned() && json_.get<std::uint64_t>() > static_cast<std::uint64_t>(max);
    const auto value = too_large ? 0 : json_.get<std::int64_t>();
    if (too_large || value < min || value > max) {
      fail(fmt::format("is not between {} and {}", min, max));
    }
    return static_cast<int>(value);
  }
  double metres() const {
    if (!json_.is_number()) fail("is not a number");
    const double value = json_.get<double>();
    if (!(std::abs(value) <= kMaxMetres)) {
      fail(fmt::format("is not between -{0:g} and {0:g}", kMaxMetres));
    }
    return value;
  }
  PlanPoint plan_point() const {
    const std::vector<Reader> both = items(2);
    return {both[0].metres(), both[1].metres()};
  }

 private:
  const Json& json_;
  std::string place_;
};

void check_version(const Reader& root) {
  if (root.at("format").text() != kFormat) root.at("format").fail("is not " + std::string(kFormat));
  const int version = root.at("format_version").integer(1, 1 << 30);
  if (version > kRoomFormatVersion) {
    root.fail(
        fmt::format("format version {} is newer than {}, the newest this program reads; use a "
                    "newer Raywalk",
                    version, kRoomFormatVersion));
  }
}

PanoramaSize read_panorama_size(const Reader& reader) {
  const PanoramaSize size{reader.at("width").integer(2, kMaxWidth),
                          reader.at("height").integer(1, kMaxWidth)};
  if (size.width != 2 * size.height) reader.fail("the width is not twice the height");
  return size;
}

// A line's id is also its file name: "x" or "z" and a number.
std::string read_line_id(const Reader& reader, LineAxis axis) {
  std::string id = reader.text();
  const bool number =
      id.size() > 1 && id.size() < 10 && id.find_first_not_of("0123456789", 1) == std::string::npos;
  if (!number || id[0] != (axis == LineAxis::kX ? 'x' : 'z')) {
    reader.fail("is not the line's axis followed by a number, such as x0");
  }
  return id;
}

LineAxis read_axis(const Reader& reader) {
  const std::string axis = reader.text();
  if (axis != "x" && axis != "z") reader.fail("is neither x nor z");
  return axis == "x" ? LineAxis::kX : LineAxis::kZ;
}

PlanPoint read_direction(const Reader& reader, LineAxis axis) {
  const PlanPoint direction = reader.plan_point();
  const double along_axis = axis == LineAxis::kX ? direction.x_m : direction.z_m;
  if (std::abs(std::hypot(direction.x_m, direction.z_m) - 1.0) > kUnitTolerance) {
    reader.fail("is not a unit vector");
  }
  // Above 45 degrees it would be a line along the other axis.
  if (along_axis < std::sqrt(0.5)) reader.fail("does not follow the line's axis");
  return direction;
}

Station read_station(const Reader& reader, const Line& line) {
  Station station;
  station.file = reader.at("file").text();
  const std::vector<Reader> position = reader.at("position_m").items(3);
  station.position_m = {position[0].metres(), position[1].metres(), position[2].metres()};
  station.along_m = reader.at("along_m").metres();
  const PlanPoint plan{station.position_m.x(), station.position_m.z()};
  const double size = 1.0 + std::abs(plan.x_m) + std::abs(plan.z_m) + std::abs(line.origin.x_m) +
                      std::abs(line.origin.z_m);
  if (std::abs(along_line(line, plan) - station.along_m) > kAlongTolerance * size) {
    reader.fail("along_m contradicts position_m");
  }
  if (!line.stations.empty() && station.along_m <= line.stations.back().along_m) {
    reader.fail("along_m does not increase");
  }
  return station;
}

Line read_line(const Reader& reader) {
  Line line;
  line.axis = read_axis(reader.at("axis"));
  line.id = read_line_id(reader.at("id"), line.axis);
  line.origin = reader.at("origin_m").plan_point();
  line.direction = read_direction(reader.at("direction"), line.axis);
  line.height_m = reader.at("height_m").metres();
  for (const Reader& station : reader.at("stations").items()) {
    line.stations.push_back(read_station(station, line));
  }
  if (line.stations.size() < 2) reader.fail("has fewer than two stations");
  return line;
}

std::string read_sha256(const Reader& reader) {
  std::string sha256 = reader.text();
  if (sha256.size() != 64 || sha256.find_first_not_of("0123456789abcdef") != std::string::npos) {
    reader.fail("is not a SHA-256 checksum");
  }
  return sha256;
}

void read_lines(const Reader& reader, RoomManifest* manifest) {
  std::set<std::string> ids;
  for (const Reader& item : reader.items()) {
    manifest->grid.lines.push_back(read_line(item));
    if (!ids.insert(manifest->grid.lines.back().id).second) {
      item.fail(fmt::format("the id {} occurs twice", manifest->grid.lines.back().id));
    }
    if (item.has("rays_sha256")) {
      manifest->rays_sha256.push_back(read_sha256(item.at("rays_sha256")));
    }
  }
  if (manifest->grid.lines.empty()) reader.fail("is empty");
  if (!manifest->rays_sha256.empty() && manifest->rays_sha256.size() != ids.size()) {
    reader.fail("some lines have a rays_sha256 and others have none");
  }
}

// Each side must lie on the cell's bounds; checked at the middle of the side.
void check_side(const Reader& reader, const Line& line, const Cell& cell, Side side) {
  const bool along_x = side == Side::kFront || side == Side::kBack;
  if ((line.axis == LineAxis::kX) != along_x) reader.fail("runs along the wrong axis");
  const double x = 0.5 * (cell.x_min_m + cell.x_max_m), z = 0.5 * (cell.z_min_m + cell.z_max_m);
  const PlanPoint& d = line.direction;
  const double at = along_x ? line.origin.z_m + (x - line.origin.x_m) * d.z_m / d.x_m
                            : line.origin.x_m + (z - line.origin.z_m) * d.x_m / d.z_m;
  const std::array<double, 4> bounds{cell.z_max_m, cell.x_max_m, cell.z_min_m, cell.x_min_m};
  const double size = std::max(cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m);
  if (std::abs(at - bounds[static_cast<size_t>(side)]) > kCellSideTolerance * size) {
    reader.fail("the line does not lie where the cell's bounds say");
  }
}

Cell read_cell(const Reader& reader, const std::vector<Line>& lines) {
  Cell cell;
  cell.x_min_m = reader.at("x_min_m").metres();
  cell.x_max_m = reader.at("x_max_m").metres();
  cell.z_min_m = reader.at("z_min_m").metres();
  cell.z_max_m = reader.at("z_max_m").metres();
  if (!(cell.x_min_m < cell.x_max_m && cell.z_min_m < cell.z_max_m)) reader.fail("has no area");
  for (size_t side = 0; side < cell.line.size(); ++side) {
    const Reader item = reader.at(kSideNames[side]);
    const std::string id = item.text();
    const auto found =
        std::find_if(lines.begin(), lines.end(), [&](const Line& line) { return line.id == id; });
    if (found == lines.end()) item.fail("names a line that does not exist");
    cell.line[side] = static_cast<int>(found - lines.begin());
    check_side(item, *found, cell, static_cast<Side>(side));
  }
  return cell;
}

Json parse_json(const std::string& text, const std::string& source) {
  const auto limit_depth = [&](int depth, nlohmann::json::parse_event_t, Json&) {
    if (depth > kMaxDepth) throw Error(source + ": nested too deeply for a manifest");
    return true;
  };
  try {
    return Json::parse(text, limit_depth);
  } catch (const nlohmann::json::exception& error) {
    throw Error(one_line(fmt::format("{}: not JSON: {}", source, error.what())));
  }
}

}  // namespace

std::string manifest_to_json(const RoomManifest& manifest) {
  Json lines = Json::array();
  for (size_t i = 0; i < manifest.grid.lines.size(); ++i) {
    lines.push_back(json_of(manifest.grid.lines[i],
                            manifest.rays_sha256.empty() ? "" : manifest.rays_sha256[i]));
  }
  Json cells = Json::array();
  for (const Cell& cell : manifest.grid.cells) cells.push_back(json_of(cell, manifest.grid.lines));
  const Json root = {
      {"format", kFormat},
      {"format_version", kRoomFormatVersion},
      {"written_by", "raywalk " RAYWALK_VERSION},
      {"frame", kFrame},
      {"panorama", {{"width", manifest.panorama.width}, {"height", manifest.panorama.height}}},
      {"lines", std::move(lines)},
      {"cells", std::move(cells)}};
  try {
    return root.dump(1) + "\n";
  } catch (const nlohmann::json::exception&) {
    throw Error(
        "a frame's file name is not UTF-8, which the manifest cannot hold; rename the file");
  }
}

RoomManifest manifest_from_json(const std::string& text, const std::string& source) {
  const Json json = parse_json(text, source);
  const Reader root(json, source);
  check_version(root);
  RoomManifest manifest;
  manifest.panorama = read_panorama_size(root.at("panorama"));
  read_lines(root.at("lines"), &manifest);
  for (const Reader& cell : root.at("cells").items()) {
    manifest.grid.cells.push_back(read_cell(cell, manifest.grid.lines));
  }
  return manifest;
}

}  // namespace raywalk
