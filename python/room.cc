#include "core/room/room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/words.h"
#include "core/room/tiled_rays.h"
#include "python/bindings.h"
#include "python/pictures.h"
#include "python/work.h"

namespace py = pybind11;

namespace raywalk::python {
namespace {

// Shared with the arrays and paths that are made from it.
using SharedRoom = std::shared_ptr<Room>;

// NumPy refuses to make an array writable again whose base is no writable buffer, as a capsule.
py::array read_only(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// A read-only array (height, width) or (height, width, channels) on columns [width][height]
// [channels] of memory that `owner` keeps alive as long as the array lives.
template <typename T>
py::array picture_of_columns(const T* columns, PanoramaSize size, int channels,
                             std::shared_ptr<const void> owner) {
  const auto pixel = static_cast<py::ssize_t>(sizeof(T)) * channels;
  std::vector<py::ssize_t> shape{size.height, size.width};
  std::vector<py::ssize_t> strides{pixel, pixel * size.height};
  if (channels > 1) {
    shape.push_back(channels);
    strides.push_back(sizeof(T));
  }
  return read_only(py::array(py::dtype::of<T>(), std::move(shape), std::move(strides), columns,
                             keeping(std::move(owner))));
}

// A line as Python names it, by its index or id.
using LineName = std::variant<int, std::string>;

const Line& line_of(const Room& room, int index) {
  return room.grid().lines[static_cast<size_t>(index)];
}

int line_index(const Room& room, const LineName& name) {
  const std::vector<Line>& lines = room.grid().lines;
  if (const int* index = std::get_if<int>(&name)) {
    if (*index >= 0 && *index < std::ssize(lines)) return *index;
    throw UsageError(fmt::format("{}: there is no line {}; give 0 to {}, or an id",
                                 room.directory().string(), *index, lines.size() - 1));
  }
  const auto& id = std::get<std::string>(name);
  const auto found = std::ranges::find(lines, id, &Line::id);
  if (found != lines.end()) return static_cast<int>(found - lines.begin());
  std::vector<std::string> ids;
  ids.reserve(lines.size());
  for (const Line& line : lines) ids.push_back(line.id);
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
  if (!volume.form().compressed()) {
    return picture_of_columns(volume.rays(station), volume.panorama(), 3, room);
  }
  const auto decoded = without_lock([&] {
    const TileReading reading;
    const auto columns = volume.columns(station);
    return std::make_shared<std::vector<std::uint8_t>>(columns.begin(), columns.end());
  });
  return picture_of_columns(decoded->data(), volume.panorama(), 3, decoded);
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
  return py::make_tuple(
      picture_of_columns(volume.distance_column(map, 0).data(), volume.size(), 1, room),
      picture_of_columns(volume.confidence_column(map, 0).data(), volume.size(), 1, room));
}

py::tuple pair_of(PlanPoint point) { return py::make_tuple(point.x_m, point.z_m); }

// The fields of raywalk.Line, in its order.
py::tuple line_fields(const Room& room, int index) {
  const Line& line = line_of(room, index);
  const auto count = std::ssize(line.stations);
  std::vector<double> positions_m, along_m;
  py::tuple files(count);
  for (const Station& station : line.stations) {
    files[along_m.size()] = station.file;
    positions_m.insert(positions_m.end(), station.position_m.begin(), station.position_m.end());
    along_m.push_back(station.along_m);
  }
  const std::span<const int> with_map = room.distances(index).stations();
  return py::make_tuple(
      line.id, name_of(line.axis), pair_of(line.origin), pair_of(line.direction), line.height_m,
      read_only(py::array_t<double>(std::vector<py::ssize_t>{count, 3}, positions_m.data())),
      read_only(py::array_t<double>(count, along_m.data())), files,
      read_only(py::array_t<int>(std::ssize(with_map), with_map.data())));
}

py::list lines(const Room& room) {
  py::list all;
  for (int i = 0; i < std::ssize(room.grid().lines); ++i) all.append(line_fields(room, i));
  return all;
}

// The fields of every raywalk.Cell, in its order.
py::list cells(const Room& room) {
  py::list all;
  for (const Cell& cell : room.grid().cells) {
    const auto id_of = [&](Side side) {
      return line_of(room, cell.line[static_cast<size_t>(side)]).id;
    };
    all.append(py::make_tuple(cell.x_min_m, cell.x_max_m, cell.z_min_m, cell.z_max_m,
                              id_of(Side::kFront), id_of(Side::kRight), id_of(Side::kBack),
                              id_of(Side::kLeft)));
  }
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
