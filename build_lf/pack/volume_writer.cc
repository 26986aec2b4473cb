#include "build_lf/pack/volume_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/room/distance_volume.h"
#include "core/room/hdf5_file.h"
#include "core/room/line_volume.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {
namespace {

constexpr const char* kWorldFrame =
    "metres; x right, y up, z forward; direction(theta, phi) = (cos phi sin theta, sin phi, cos "
    "phi cos theta)";
constexpr const char* kPixelGrid =
    "theta = (i + 0.5) / width * 360 - 180 degrees; phi = 90 - (j + 0.5) / height * 180 degrees";

void describe_file(Hdf5File* file, const char* format, const Line& line,
                   const std::string& inputs) {
  file->write_format(format);
  if (!inputs.empty()) file->write_attribute("/", kInputsAttribute, inputs);
  file->write_attribute("/", "line", line.id);
  file->write_attribute("/", "frame", kWorldFrame);
  file->write_attribute("/", "pixel_grid", kPixelGrid);
}

void describe_dataset(Hdf5File* file, const char* dataset, const char* axes, const char* unit) {
  file->write_attribute(dataset, "axes", axes);
  file->write_attribute(dataset, "unit", unit);
}

void write_positions(Hdf5File* file, const Line& line) {
  std::vector<double> positions;
  for (const Station& station : line.stations) {
    positions.insert(positions.end(), station.position_m.begin(), station.position_m.end());
  }
  file->write("position_m", positions, {line.stations.size(), 3});
  describe_dataset(file, "position_m", "station, xyz", "m");
}

void write_checksums(Hdf5File* file, const std::vector<std::string>& sha256, const char* covers) {
  file->write_strings("sha256", sha256);
  file->write_attribute("sha256", "covers", covers);
}

// Where a result lies in the file depends on the order of storing only if it is compressed.
enum class StoreOrder { kAny, kByIndex };

// Conversions of a few indices at a time, whose results are stored in order, so that the same
// content has the same bytes.
template <typename Convert, typename Store>
void convert_and_store_in_order(std::size_t count, const Convert& convert, const Store& store) {
  const auto at_once = 4 * static_cast<std::size_t>(thread_count());
  for (std::size_t first = 0; first < count; first += at_once) {
    using Result = std::invoke_result_t<Convert, std::size_t>;
    std::vector<std::optional<Result>> results(std::min(at_once, count - first));
    parallel_for(0, static_cast<int>(results.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        results[i] = convert(first + i);
      }
    });
    for (std::size_t i = 0; i < results.size(); ++i) store(first + i, *results[i]);
  }
}

// For i in [0, count), calls convert(i) in parallel and store(i, result) one at a time, as HDF5 is
// not thread-safe.
template <typename Convert, typename Store>
void convert_and_store(std::size_t count, StoreOrder order, const Convert& convert,
                       const Store& store) {
  if (order == StoreOrder::kByIndex) {
    convert_and_store_in_order(count, convert, store);
    return;
  }
  std::mutex hdf5;
  parallel_for(0, static_cast<int>(count), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto result = convert(static_cast<std::size_t>(i));
      const std::lock_guard lock(hdf5);
      store(static_cast<std::size_t>(i), result);
    }
  });
}

// In a masked line, makes all rows valid for a station without a mask; in a line without masks,
// drops valid rows.
void complete_valid_rows(const LineRays& rays, StationRays* station) {
  if (!rays.masked) station->valid_rows.clear();
  if (!rays.masked || !station->valid_rows.empty()) return;
  for (int u = 0; u < rays.panorama.width; ++u) {
    station->valid_rows.insert(station->valid_rows.end(), {0, rays.panorama.height});
  }
}

void describe_maps(Hdf5File* hdf5, const DistanceMaps& maps,
                   const std::vector<std::string>& sha256) {
  if (!maps.left_out.empty()) {
    hdf5->write("left_out", maps.left_out, {maps.left_out.size() / 4, 4});
    describe_dataset(hdf5, "left_out", "run, (station, theta, first row, one past the last)",
                     "pixels of the maps; what moved: not to be used where another station sees "
                     "the place");
  }
  describe_dataset(hdf5, "distance_m", "map, theta, phi", "m along the ray; inf: no surface");
  describe_dataset(hdf5, "confidence", "map, theta, phi", "0: unknown, 255: certain");
  write_checksums(hdf5, sha256,
                  "sha256(text of sha256(distance_m[map]) and sha256(confidence[map]))");
}

}  // namespace

void write_line_volume(const std::filesystem::path& file, const Line& line, const LineRays& rays,
                       Progress* progress) {
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  describe_file(&hdf5, kLineVolumeFormat, line, rays.inputs);
  write_positions(&hdf5, line);
  const std::size_t count = line.stations.size();
  const auto width = static_cast<std::size_t>(rays.panorama.width);
  std::optional<TiledRaysWriter> tiles;
  if (rays.form.compressed()) {
    tiles.emplace(&hdf5, rays.form, static_cast<int>(count), rays.panorama,
                  TileLayout::usual(rays.panorama));
  } else {
    hdf5.create_contiguous("rays", ElementType::kUint8,
                           {count, width, static_cast<std::size_t>(rays.panorama.height), 3});
  }
  if (rays.masked) hdf5.create_contiguous("valid_rows", ElementType::kInt32, {count, width, 2});
  std::vector<std::string> sha256(count);
  const auto read = [&](std::size_t i) {
    StationRays station = rays.read(i);
    complete_valid_rows(rays, &station);
    TiledRaysWriter::Encoded encoded;
    if (tiles) encoded = tiles->encode(station.rays);
    sha256[i] = checksum_of_rays(station.rays, station.valid_rows);
    if (tiles) station.rays = {};  // frees the memory
    return std::pair(std::move(station), std::move(encoded));
  };
  const auto order = tiles ? StoreOrder::kByIndex : StoreOrder::kAny;
  convert_and_store(count, order, read, [&](std::size_t i, const auto& converted) {
    const auto& [station, encoded] = converted;
    if (tiles) {
      tiles->write(static_cast<int>(i), encoded);
    } else {
      hdf5.write_slab("rays", i, station.rays.data());
    }
    if (rays.masked) hdf5.write_slab("valid_rows", i, station.valid_rows.data());
    progress->advance();
  });
  if (tiles) tiles->complete();
  describe_dataset(&hdf5, "rays", "station, theta, phi, rgb", "sRGB, 0 to 255");
  if (rays.masked) {
    describe_dataset(&hdf5, "valid_rows", "station, theta, (first, one past last)",
                     "rows that may be used");
  }
  write_checksums(&hdf5, sha256,
                  rays.masked
                      ? "sha256(text of sha256(rays[station]) and sha256(valid_rows[station]))"
                      : "rays[station]");
  hdf5.close();
  output.commit();
}

void write_distance_volume(const std::filesystem::path& file, const Line& line,
                           const DistanceMaps& maps, Progress* progress) {
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  describe_file(&hdf5, kDistanceVolumeFormat, line, maps.inputs);
  hdf5.write_attribute("/", "origin", maps.origin);
  hdf5.write_attribute("/", "stations_sha256", sha256_of(line));
  hdf5.write("station", maps.stations);
  std::vector<std::string> sha256(maps.stations.size());
  if (!maps.stations.empty()) {
    const Shape shape{maps.stations.size(), static_cast<std::size_t>(maps.size.width),
                      static_cast<std::size_t>(maps.size.height)};
    const auto create = [&](const char* name, ElementType type) {
      maps.compressed ? hdf5.create_deflated(name, type, shape)
                      : hdf5.create_contiguous(name, type, shape);
    };
    create("distance_m", ElementType::kFloat32);
    create("confidence", ElementType::kUint8);
    convert_and_store(maps.stations.size(),
                      maps.compressed ? StoreOrder::kByIndex : StoreOrder::kAny, maps.read,
                      [&](std::size_t i, const StationDistances& station) {
                        hdf5.write_slab("distance_m", i, station.distance_m.data());
                        hdf5.write_slab("confidence", i, station.confidence.data());
                        sha256[i] = station.sha256;
                        progress->advance();
                      });
    describe_maps(&hdf5, maps, sha256);
  }
  DistanceHeader header{.line = line.id, .origin = maps.origin, .stations = maps.stations};
  if (!maps.stations.empty()) {
    header.size = maps.size;
    header.map_sha256 = sha256;
    header.left_out = maps.left_out;
  }
  hdf5.write_attribute("/", "header_sha256", sha256_of(header));
  hdf5.close();
  output.commit();
}

std::string inputs_of(const std::filesystem::path& volume) {
  std::error_code error;
  if (!std::filesystem::exists(volume, error)) return "";
  try {
    return Hdf5File::open(volume).text_attribute(kInputsAttribute).value_or("");
  } catch (const Error&) {
    return "";
  }
}

void copy_volume(const std::filesystem::path& from, const std::filesystem::path& to) {
  AtomicFile output(to);
  std::error_code error;
  std::filesystem::copy_file(from, output.temporary_path(),
                             std::filesystem::copy_options::overwrite_existing, error);
  if (error) {
    throw Error(
        fmt::format("{}: cannot be copied to {}: {}", from.string(), to.string(), error.message()));
  }
  output.commit();
}

}  // namespace raywalk::build_lf
