// For tests: a packed room of an analytic scene, whose frames can be edited before packing, and
// what a depth run leaves in it.
#pragma once

#include <functional>
#include <map>
#include <memory_resource>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/station_picture.h"
#include "build_lf/pack/distance_sets.h"
#include "build_lf/pack/volume_writer.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/geometry/test_pixels.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {

// A box room around a cell of side 1 m, all its lengths times `scale`.
inline SyntheticRoomSpec room_of_scale(double scale, unsigned seed = 1) {
  SyntheticRoomSpec spec;
  spec.scene.walls.min_m *= scale;
  spec.scene.walls.max_m *= scale;
  spec.scene.texture_wavelength_m = scale;
  spec.scene.seed = seed;
  spec.side_m = scale;
  spec.spacing_m = 0.0625 * scale;
  spec.width = 128;
  return spec;
}

// The same with a single line of stations, x0.
inline SyntheticRoomSpec line_of_scale(double scale, unsigned seed = 1) {
  SyntheticRoomSpec spec = room_of_scale(scale, seed);
  spec.cells_z = 0;
  return spec;
}

// Exact inverse distances of a scene.
inline InverseDistanceMap true_map(const SyntheticScene& scene, const Eigen::Vector3d& position_m,
                                   PanoramaSize size) {
  InverseDistanceMap map{{}, position_m, size, {}, {}};
  for (const auto [u, v] : pixels_of(size)) {
    const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
    const double distance_m = distance_at(scene, position_m, direction_from_angles(angles));
    map.inverse.push_back(static_cast<float>(1.0 / distance_m));
  }
  map.confidence.assign(map.inverse.size(), 255);
  return map;
}

class DepthTestRoom {
 public:
  // Edits a frame (BGR, CV_8UC3). Called on several threads.
  using Edit = std::function<void(StationIndex station, cv::Mat* frame)>;

  // A station's mask, CV_8UC1 of the frame's size; 0 = invalid. Called on several threads.
  using Mask = std::function<cv::Mat(StationIndex station)>;

  explicit DepthTestRoom(const SyntheticRoomSpec& spec, const Edit& edit = nullptr,
                         const Mask& mask = nullptr)
      : DepthTestRoom(spec, synthetic_grid(spec), edit, mask) {}

  // The scene of `spec` captured from the given grid.
  DepthTestRoom(const SyntheticRoomSpec& spec, const Grid& grid, const Edit& edit,
                const Mask& mask = nullptr)
      : room_(write(spec, grid, edit, mask)) {}

  const Room& room() const { return room_; }
  const Grid& grid() const { return room_.grid(); }

  // Adds exact distances, as if they had been packed with the room, at every n-th station.
  void give_distances(const SyntheticScene& scene, PanoramaSize size, int every = 1) {
    std::filesystem::create_directories(distances_directory(path(), DistanceKind::kGiven));
    for (const Line& line : grid().lines) {
      DistanceMaps maps{{}, size, kGivenOrigin, {}};
      for (int i = 0; i < static_cast<int>(line.stations.size()); i += every) {
        maps.stations.push_back(i);
      }
      maps.read = [&](size_t i) {
        const auto station = static_cast<size_t>(maps.stations[i]);
        return distances_from(true_map(scene, line.stations[station].position_m, size));
      };
      Progress progress("giving", static_cast<std::int64_t>(maps.stations.size()), "maps");
      write_distance_volume(distance_volume_path(path(), line.id), line, maps, &progress);
    }
    use_distances(path(), DistanceKind::kGiven);
    room_ = Room::open(path());
  }

 private:
  // In the directory, so that rooms made beside it are removed too.
  std::filesystem::path path() const { return directory_ / "room.lf"; }

  Room write(const SyntheticRoomSpec& spec, const Grid& grid, const Edit& edit,
             const Mask& mask) const {
    const PanoramaSize size{spec.width, spec.width / 2};
    std::filesystem::create_directories(path() / "lines");
    for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
      const Line& stations = grid.lines[line];
      Progress progress("packing", static_cast<std::int64_t>(stations.stations.size()), "stations");
      const auto rays_of = [&](size_t i) {
        cv::Mat frame = render_scene(spec.scene, stations.stations[i].position_m, spec.width);
        if (edit) edit({line, static_cast<int>(i)}, &frame);
        StationRays rays = rays_from(frame);
        if (mask) rays.valid_rows = valid_rows_of(mask({line, static_cast<int>(i)}));
        return rays;
      };
      write_line_volume(line_volume_path(path(), stations.id), stations,
                        {size, mask != nullptr, rays_of}, &progress);
    }
    write_file_atomically(manifest_path(path()), manifest_to_json({size, grid, {}}));
    return Room::open(path());
  }

  static StationRays rays_from(const cv::Mat& frame) {
    StationRays station;
    for (const auto [u, v] : pixels_of({frame.cols, frame.rows})) {
      const auto& bgr = frame.at<cv::Vec3b>(v, u);
      station.rays.insert(station.rays.end(), {bgr[2], bgr[1], bgr[0]});
    }
    return station;
  }

  static StationDistances distances_from(const InverseDistanceMap& map) {
    StationDistances station{{}, map.confidence, {}};
    for (const float inverse : map.inverse) station.distance_m.push_back(1.0f / inverse);
    station.sha256 = checksum_of_distances(station.distance_m, station.confidence);
    return station;
  }

  TestDirectory directory_;
  Room room_;
};

// The pictures of a room's stations, at maps of `size`; the arguments must outlive it.
inline PictureCache pictures_of(
    const Room& room, PanoramaSize size, const GainFields& gains, const cv::Mat& valid = {},
    std::pmr::memory_resource* memory = std::pmr::get_default_resource()) {
  return {100, [&room, &gains, size, valid, memory](StationIndex station) {
            return make_station_picture(room, station, size, gain_field(gains, station), valid,
                                        false, memory);
          }};
}

// Normally distributed noise, different for each station.
inline void add_noise(StationIndex station, double deviation, cv::Mat* frame) {
  cv::RNG random(static_cast<std::uint64_t>(1000 * station.line + station.station + 1));
  cv::Mat noise(frame->size(), CV_16SC3);
  random.fill(noise, cv::RNG::NORMAL, 0.0, deviation);
  cv::add(*frame, noise, *frame, cv::noArray(), CV_8U);
}

// Share of the pixels of `map` selected by `counts(pixel)` with an error below `tolerance_per_m`,
// weighted by solid angle.
template <typename Counts>
double share_within(const InverseDistanceMap& map, const InverseDistanceMap& truth,
                    double tolerance_per_m, const Counts& counts) {
  double within = 0.0;
  double all = 0.0;
  for (size_t pixel = 0; pixel < map.inverse.size(); ++pixel) {
    if (!counts(pixel)) continue;
    const double row = static_cast<double>(pixel % static_cast<size_t>(map.size.height));
    const double solid_angle = std::sin((row + 0.5) / map.size.height * kPi);
    all += solid_angle;
    if (std::fabs(map.inverse[pixel] - truth.inverse[pixel]) < tolerance_per_m)
      within += solid_angle;
  }
  return all > 0.0 ? within / all : 0.0;
}
// The same of all pixels.
inline double share_within(const InverseDistanceMap& map, const InverseDistanceMap& truth,
                           double tolerance_per_m) {
  return share_within(map, truth, tolerance_per_m, [](size_t) { return true; });
}

// Checksums of all files of a room but what tells of the run itself, which is in depth.html too.
inline std::map<std::string, std::string> result_files_of(const std::filesystem::path& room) {
  std::map<std::string, std::string> files = checksums_of_files(room);
  for (const std::string folder : {"", "held-out/"}) {
    const std::filesystem::path json = room / (folder + "depth.json");
    if (!std::filesystem::exists(json)) continue;
    auto document = nlohmann::json::parse(read_file(json));
    for (const char* key : {"room", "page", "seconds", "peak_memory_mb"}) document.erase(key);
    files[folder + "depth.json"] = document.dump();
    files.erase(folder + "depth.html");
  }
  return files;
}

}  // namespace raywalk::build_lf
