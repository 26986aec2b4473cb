#include "python/room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/words.h"
#include "core/room/tiled_rays.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// A line as Python names it, by its index or id.
using LineName = std::variant<int, std::string>;

const Line& line_of(const Room& room, int index) {
  return room.grid().lines[static_cast<size_t>(index)];
}

std::vector<std::string> line_ids(const Room& room) {
  std::vector<std::string> ids;
  for (const Line& line : room.grid().lines) ids.push_back(line.id);
  return ids;
}

int line_index(const Room& room, const LineName& name) {
  const std::vector<std::string> ids = line_ids(room);
  if (const int* index = std::get_if<int>(&name)) {
    if (*index >= 0 && *index < std::ssize(ids)) return *index;
    throw UsageError(fmt::format("{}: there is no line {}; give 0 to {}, or an id",
                                 room.directory().string(), *index, ids.size() - 1));
  }
  const auto& id = std::get<std::string>(name);
  const auto found = std::ranges::find(ids, id);
  if (found != ids.end()) return static_cast<int>(found - ids.begin());
  throw UsageError(fmt::format("{}: there is no line {}{}", room.directory().string(), excerpt(id),
                               suggestion(id, ids)));
}

void require_station(const Room& room, int line, int station) {
  const int stations = room.volume(line).stations();
  if (station >= 0 && station < stations) return;
  throw UsageError(fmt::format("{}: line {} has no station {}; give 0 to {}",
                               room.directory().string(), line_of(room, line).id, station,
                               stations - 1));
}

py::array frame(const SharedRoom& room, const LineName& name, int station) {
  const int line = line_index(*room, name);
  require_station(*room, line, station);
  const LineVolume& volume = room->volume(line);
  const PanoramaSize size = volume.panorama();
  if (!volume.form().compressed()) {
    return picture_of_columns(volume.rays(station), size.width, size.height, 3, room);
  }
  const auto decoded = without_lock([&] {
    const TileReading reading;
    const auto columns = volume.columns(station);
    return std::make_shared<std::vector<std::uint8_t>>(columns.begin(), columns.end());
  });
  return picture_of_columns(decoded->data(), size.width, size.height, 3, decoded);
}

// The index of a station's map. Throws Error where it has none.
int map_index(const Room& room, int line, int station) {
  const std::span<const int> stations = room.distances(line).stations();
  const std::string& id = line_of(room, line).id;
  if (stations.empty()) {
    throw Error(
        fmt::format("{}: line {} has no distance maps; estimate them with raywalk-build-lf depth",
                    room.directory().string(), id));
  }
  const auto found = std::ranges::find(stations, station);
  if (found != stations.end()) return static_cast<int>(found - stations.begin());
  throw Error(fmt::format("{}: station {} of line {} has no distance map; stations {} have one",
                          room.directory().string(), station, id, fmt::join(stations, ", ")));
}

// distance_m and confidence of a station.
py::tuple distances(const SharedRoom& room, const LineName& name, int station) {
  const int line = line_index(*room, name);
  require_station(*room, line, station);
  const int map = map_index(*room, line, station);
  const DistanceVolume& volume = room->distances(line);
  const PanoramaSize size = volume.size();
  return py::make_tuple(
      picture_of_columns(volume.distance_column(map, 0).data(), size.width, size.height, 1, room),
      picture_of_columns(volume.confidence_column(map, 0).data(), size.width, size.height, 1,
                         room));
}

py::tuple pair_of(PlanPoint point) { return py::make_tuple(point.x_m, point.z_m); }

// The fields of raywalk.Line.
py::dict line_fields(const Room& room, int index) {
  const Line& line = line_of(room, index);
  const auto count = std::ssize(line.stations);
  std::vector<double> positions_m, along_m;
  py::tuple files(count);
  for (py::ssize_t i = 0; i < count; ++i) {
    const Station& station = line.stations[static_cast<size_t>(i)];
    positions_m.insert(positions_m.end(), station.position_m.begin(), station.position_m.end());
    along_m.push_back(station.along_m);
    files[i] = station.file;
  }
  const std::span<const int> with_map = room.distances(index).stations();
  py::dict fields;
  fields["id"] = line.id;
  fields["axis"] = name_of(line.axis);
  fields["origin_m"] = pair_of(line.origin);
  fields["direction"] = pair_of(line.direction);
  fields["height_m"] = line.height_m;
  fields["positions_m"] = read_only_copy(std::span<const double>(positions_m), {count, 3});
  fields["along_m"] = read_only_copy(std::span<const double>(along_m), {count});
  fields["files"] = files;
  fields["distance_stations"] = read_only_copy(with_map, {std::ssize(with_map)});
  return fields;
}

// The fields of raywalk.Cell.
py::dict cell_fields(const Room& room, const Cell& cell) {
  const auto id_of = [&](Side side) {
    return line_of(room, cell.line[static_cast<size_t>(side)]).id;
  };
  py::dict fields;
  fields["x_min_m"] = cell.x_min_m;
  fields["x_max_m"] = cell.x_max_m;
  fields["z_min_m"] = cell.z_min_m;
  fields["z_max_m"] = cell.z_max_m;
  fields["front"] = id_of(Side::kFront);
  fields["right"] = id_of(Side::kRight);
  fields["back"] = id_of(Side::kBack);
  fields["left"] = id_of(Side::kLeft);
  return fields;
}

py::list lines(const Room& room) {
  py::list all;
  for (int i = 0; i < std::ssize(room.grid().lines); ++i) all.append(line_fields(room, i));
  return all;
}

py::list cells(const Room& room) {
  py::list all;
  for (const Cell& cell : room.grid().cells) all.append(cell_fields(room, cell));
  return all;
}

SharedRoom open(const std::filesystem::path& directory) {
  return without_lock([&directory] { return std::make_shared<Room>(Room::open(directory)); });
}

std::string description(const Room& room) {
  return fmt::format("<raywalk.Room {}: {}, {}, panoramas {}x{}, distances {}>",
                     room.directory().string(), counted(room.grid().lines.size(), "line"),
                     counted(room.grid().cells.size(), "cell"), room.panorama().width,
                     room.panorama().height, room.distances_origin());
}

}  // namespace

void bind_room(py::module_& module) {
  py::class_<Room, SharedRoom>(module, "Room")
      .def(py::init(&open))
      .def("directory", [](const Room& self) { return self.directory(); })
      .def("panorama_size_px",
           [](const Room& self) {
             return py::make_tuple(self.panorama().width, self.panorama().height);
           })
      .def("lines", &lines)
      .def("line_index", &line_index)
      .def("cells", &cells)
      .def("cell_index",
           [](const Room& self, double x_m, double z_m) {
             return find_cell(self.grid(), {x_m, z_m});
           })
      .def("distances_origin", &Room::distances_origin)
      .def("frame", &frame)
      .def("distances", &distances)
      .def("__repr__", &description);
}

}  // namespace raywalk::python
