#include "build_lf/volume_writer.h"

#include <array>
#include <mutex>

#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/room/distance_volume.h"
#include "core/room/hdf5_file.h"
#include "core/room/line_volume.h"

namespace raywalk {
namespace {

constexpr const char* kWorldFrame =
    "metres; x right, y up, z forward; direction(theta, phi) = (cos phi sin theta, sin phi, cos "
    "phi cos "
    "theta)";
constexpr const char* kPixelGrid =
    "theta = (i + 0.5) / width * 360 - 180 degrees; phi = 90 - (j + 0.5) / height * 180 degrees";

void describe_file(Hdf5File* file, const char* format, const Line& line) {
  file->write_attribute("/", "format", format);
  file->write_attribute("/", "format_version", kVolumeFormatVersion);
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
  file->write_float64("position_m", positions, std::array<std::size_t, 2>{line.stations.size(), 3});
  describe_dataset(file, "position_m", "station, xyz", "m");
}

void write_checksums(Hdf5File* file, const std::vector<std::string>& sha256, const char* covers) {
  file->write_strings("sha256", sha256);
  file->write_attribute("sha256", "covers", covers);
}

// Calls convert(i) in parallel and store(i, result), one at a time because of HDF5, for i in
// [0, count).
template <typename Convert, typename Store>
void convert_and_store(std::size_t count, const Convert& convert, const Store& store) {
  std::mutex hdf5;
  parallel_for(0, static_cast<int>(count), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto result = convert(static_cast<std::size_t>(i));
      const std::lock_guard lock(hdf5);
      store(static_cast<std::size_t>(i), result);
    }
  });
}

}  // namespace

void write_line_volume(const std::filesystem::path& file, const Line& line,
                       const std::vector<StationSource>& sources, PanoramaSize panorama,
                       Progress* progress) {
  write_line_volume(
      file, line, panorama, [&](std::size_t i) { return read_station_rays(sources[i], panorama); },
      progress);
}

void write_line_volume(const std::filesystem::path& file, const Line& line, PanoramaSize panorama,
                       const std::function<StationRays(std::size_t station)>& rays_of,
                       Progress* progress) {
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  describe_file(&hdf5, kLineVolumeFormat, line);
  write_positions(&hdf5, line);
  const std::size_t count = line.stations.size();
  const std::array<std::size_t, 4> shape{count, static_cast<std::size_t>(panorama.width),
                                         static_cast<std::size_t>(panorama.height), 3};
  std::vector<std::string> sha256(count);
  {
    const Hdf5Handle rays = hdf5.create_contiguous("rays", H5T_STD_U8LE, shape);
    convert_and_store(count, rays_of, [&](std::size_t i, const StationRays& station) {
      hdf5.write_slab(rays, i, H5T_NATIVE_UINT8, shape, station.rays.data());
      sha256[i] = station.sha256;
      progress->advance();
    });
  }
  describe_dataset(&hdf5, "rays", "station, theta, phi, rgb", "sRGB, 0 to 255");
  write_checksums(&hdf5, sha256, "rays[station], as stored");
  hdf5.close();
  output.commit();
}

void write_distance_volume(const std::filesystem::path& file, const Line& line,
                           const DistanceMaps& maps, Progress* progress) {
  AtomicFile output(file);
  Hdf5File hdf5 = Hdf5File::create(output.temporary_path());
  describe_file(&hdf5, kDistanceVolumeFormat, line);
  hdf5.write_attribute("/", "origin", maps.origin);
  hdf5.write_int32("station", maps.stations);
  const std::array<std::size_t, 3> shape{maps.stations.size(),
                                         static_cast<std::size_t>(maps.size.width),
                                         static_cast<std::size_t>(maps.size.height)};
  std::vector<std::string> sha256(maps.stations.size());
  {
    const Hdf5Handle distance = hdf5.create_contiguous("distance_m", H5T_IEEE_F32LE, shape);
    const Hdf5Handle confidence = hdf5.create_contiguous("confidence", H5T_STD_U8LE, shape);
    convert_and_store(
        maps.stations.size(), maps.read, [&](std::size_t i, const StationDistances& station) {
          hdf5.write_slab(distance, i, H5T_NATIVE_FLOAT, shape, station.distance_m.data());
          hdf5.write_slab(confidence, i, H5T_NATIVE_UINT8, shape, station.confidence.data());
          sha256[i] = station.sha256;
          progress->advance();
        });
  }
  describe_dataset(&hdf5, "distance_m", "map, theta, phi", "m along the ray; inf: no surface");
  describe_dataset(&hdf5, "confidence", "map, theta, phi", "0: unknown, 255: certain");
  write_checksums(&hdf5, sha256,
                  "sha256(text of sha256(distance_m[map]) and sha256(confidence[map]))");
  hdf5.close();
  output.commit();
}

}  // namespace raywalk
