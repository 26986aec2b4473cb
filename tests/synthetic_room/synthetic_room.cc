#include "tests/synthetic_room/synthetic_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/room/hdf5_file.h"
#include "core/room/room.h"
#include "core/room/tiled_rays.h"

namespace raywalk {
namespace {

// A line along `axis` at `across_m` on the other plan axis, of length `length_m` centred at 0.
Line make_line(const SyntheticRoomSpec& spec, LineAxis axis, int index, double across_m,
               double length_m) {
  Line line;
  const bool along_x = axis == LineAxis::kX;
  line.id = fmt::format("{}{}", along_x ? 'x' : 'z', index);
  line.axis = axis;
  line.origin = along_x ? PlanPoint{0.0, across_m} : PlanPoint{across_m, 0.0};
  line.direction = along_x ? PlanPoint{1.0, 0.0} : PlanPoint{0.0, 1.0};
  line.height_m = spec.height_m;
  const int steps = std::max(1, static_cast<int>(std::lround(length_m / spec.spacing_m)));
  for (int i = 0; i <= steps; ++i) {
    const double along_m = length_m * (static_cast<double>(i) / steps - 0.5);
    const OffLine off = spec.off_line ? spec.off_line(line.id, i) : OffLine();
    const double across = across_m + off.across_m, height = spec.height_m + off.up_m;
    line.stations.push_back({.file = fmt::format("{}_{:03}.png", line.id, i),
                             .position_m = along_x ? Eigen::Vector3d(along_m, height, across)
                                                   : Eigen::Vector3d(across, height, along_m),
                             .along_m = along_m});
  }
  return line;
}

// Writes one dataset slab by slab: slab(i) returns its values.
template <typename Slab>
void write_dataset(Hdf5File* file, const char* name, ElementType type, const Shape& shape,
                   const Slab& slab) {
  file->create_contiguous(name, type, shape);
  for (std::size_t i = 0; i < shape.front(); ++i) file->write_slab(name, i, slab(i).data());
}

bool companion_hides(const SyntheticRoomSpec& spec, const Line& line, std::size_t station,
                     PanoramaSize size, int u, int v) {
  return spec.companion->hides(
      line.id, static_cast<int>(station),
      direction_from_angles(angles_from_pixel({double(u), double(v)}, size)));
}

void paint_companion(const SyntheticRoomSpec& spec, const Line& line, std::size_t station,
                     cv::Mat* image) {
  const Eigen::Vector3d& rgb = spec.companion->color;
  const cv::Vec3b bgr(cv::saturate_cast<uchar>(rgb.z()), cv::saturate_cast<uchar>(rgb.y()),
                      cv::saturate_cast<uchar>(rgb.x()));
  const PanoramaSize size{image->cols, image->rows};
  for (int v = 0; v < image->rows; ++v) {
    for (int u = 0; u < image->cols; ++u) {
      if (companion_hides(spec, line, station, size, u, v)) image->at<cv::Vec3b>(v, u) = bgr;
    }
  }
}

// [theta][2]: the rows above the companion.
std::vector<std::int32_t> valid_rows(const SyntheticRoomSpec& spec, const Line& line,
                                     std::size_t station) {
  const PanoramaSize size{spec.width, spec.width / 2};
  std::vector<std::int32_t> rows;
  for (int u = 0; u < spec.width; ++u) {
    int end = 0;
    while (end < spec.width / 2 && !companion_hides(spec, line, station, size, u, end)) ++end;
    rows.insert(rows.end(), {0, end});
  }
  return rows;
}

void write_rays(const SyntheticRoomSpec& spec, const Line& line,
                const std::filesystem::path& path) {
  const auto gain = spec.line_gain.find(line.id);
  const std::size_t width = static_cast<std::size_t>(spec.width);
  Hdf5File file = Hdf5File::create(path);
  const bool masked = spec.companion && spec.companion->masked;
  file.write_format(kLineVolumeFormat);
  if (masked) {
    write_dataset(&file, "valid_rows", ElementType::kInt32, {line.stations.size(), width, 2},
                  [&](std::size_t station) { return valid_rows(spec, line, station); });
  }
  const auto rays_of = [&](std::size_t station) {
    cv::Mat image = render_scene(spec.scene, line.stations[station].position_m, spec.width,
                                 gain == spec.line_gain.end() ? 1.0 : gain->second);
    if (spec.companion) paint_companion(spec, line, station, &image);
    std::vector<std::uint8_t> rays;
    for (int u = 0; u < image.cols; ++u) {
      for (int v = 0; v < image.rows; ++v) {
        const auto& bgr = image.at<cv::Vec3b>(v, u);
        rays.insert(rays.end(), {bgr[2], bgr[1], bgr[0]});
      }
    }
    return rays;
  };
  if (spec.form.compressed()) {
    const PanoramaSize size{spec.width, spec.width / 2};
    TiledRaysWriter writer(&file, spec.form, static_cast<int>(line.stations.size()), size,
                           {size, spec.tile_columns});
    for (std::size_t station = 0; station < line.stations.size(); ++station) {
      std::vector<std::uint8_t> rays = rays_of(station);
      writer.write(static_cast<int>(station), writer.encode(rays));
    }
    writer.complete();
  } else {
    write_dataset(&file, "rays", ElementType::kUint8, {line.stations.size(), width, width / 2, 3},
                  rays_of);
  }
  file.close();
}

std::vector<float> distance_map(const SyntheticRoomSpec& spec, const Eigen::Vector3d& origin_m,
                                PanoramaSize size) {
  std::vector<float> metres;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) {
      const SphereAngles angles = angles_from_pixel({double(u), double(v)}, size);
      const double exact_m = distance_at(spec.scene, origin_m, direction_from_angles(angles));
      metres.push_back(spec.stored_distance ? spec.stored_distance(u, v, exact_m)
                                            : static_cast<float>(exact_m));
    }
  }
  return metres;
}

std::vector<std::uint8_t> confidence_map(const SyntheticRoomSpec& spec, PanoramaSize size) {
  std::vector<std::uint8_t> confidence;
  for (int u = 0; u < size.width; ++u) {
    for (int v = 0; v < size.height; ++v) {
      confidence.push_back(spec.stored_confidence ? spec.stored_confidence(u, v) : 255);
    }
  }
  return confidence;
}

bool companion_touches(const SyntheticRoomSpec& spec, const Line& line, std::size_t station,
                       PanoramaSize size, int u, int v) {
  for (int column = u - 1; column <= u + 1; ++column) {
    for (int row = v - 1; row <= v + 1; ++row) {
      if (companion_hides(spec, line, station, size, column, row)) return true;
    }
  }
  return false;
}

// [run][station, theta, first row, one past the last]: the companion's pixels and those around,
// which smaller maps cut.
std::vector<std::int32_t> companion_runs(const SyntheticRoomSpec& spec, const Line& line,
                                         PanoramaSize size) {
  std::vector<std::int32_t> runs;
  for (std::size_t station = 0; station < line.stations.size(); ++station) {
    for (int u = 0; u < size.width; ++u) {
      for (int v = 0; v < size.height; ++v) {
        if (!companion_touches(spec, line, station, size, u, v)) continue;
        runs.insert(runs.end(), {static_cast<std::int32_t>(station), u, v, v + 1});
      }
    }
  }
  return runs;
}

void write_distances(const SyntheticRoomSpec& spec, const Line& line,
                     const std::filesystem::path& path) {
  std::vector<std::int32_t> stations;
  for (std::size_t i = 0; i < line.stations.size();
       i += static_cast<std::size_t>(spec.distance_every)) {
    stations.push_back(static_cast<std::int32_t>(i));
  }
  const int width = spec.distance_width > 0 ? spec.distance_width : spec.width;
  const PanoramaSize size{width, width / 2};
  const Shape shape{stations.size(), static_cast<std::size_t>(size.width),
                    static_cast<std::size_t>(size.height)};
  Hdf5File file = Hdf5File::create(path);
  file.write_format(kDistanceVolumeFormat);
  file.write("station", stations);
  write_dataset(&file, "distance_m", ElementType::kFloat32, shape, [&](std::size_t map) {
    const auto station = static_cast<std::size_t>(stations[map]);
    return distance_map(spec, line.stations[station].position_m, size);
  });
  write_dataset(&file, "confidence", ElementType::kUint8, shape,
                [&](std::size_t) { return confidence_map(spec, size); });
  if (spec.companion && spec.companion->left_out) {
    const std::vector<std::int32_t> runs = companion_runs(spec, line, size);
    if (!runs.empty()) file.write("left_out", runs, {runs.size() / 4, 4});
  }
  file.close();
}

}  // namespace

Grid synthetic_grid(const SyntheticRoomSpec& spec) {
  Grid grid;
  const double length_x_m = spec.cells_x * spec.side_m;
  const double length_z_m = spec.cells_z * spec.side_m;
  const auto x_of = [&](int i) { return i * spec.side_m - 0.5 * length_x_m; };
  const auto z_of = [&](int j) { return j * spec.side_m - 0.5 * length_z_m; };
  for (int j = 0; j <= spec.cells_z; ++j) {
    grid.lines.push_back(
        make_line(spec, LineAxis::kX, j, z_of(j), length_x_m + 2.0 * spec.overhang_m));
  }
  if (spec.cells_z == 0) return grid;
  const int first_z_line = spec.cells_z + 1;
  for (int i = 0; i <= spec.cells_x; ++i) {
    grid.lines.push_back(
        make_line(spec, LineAxis::kZ, i, x_of(i), length_z_m + 2.0 * spec.overhang_m));
  }
  for (int j = 0; j < spec.cells_z; ++j) {
    for (int i = 0; i < spec.cells_x; ++i) {
      grid.cells.push_back({.x_min_m = x_of(i),
                            .x_max_m = x_of(i + 1),
                            .z_min_m = z_of(j),
                            .z_max_m = z_of(j + 1),
                            .line = {j + 1, first_z_line + i + 1, j, first_z_line + i}});
    }
  }
  return grid;
}

void write_synthetic_room(const SyntheticRoomSpec& spec, const std::filesystem::path& room) {
  std::filesystem::remove_all(room);
  std::filesystem::create_directories(room / "lines");
  if (spec.distances) {
    std::filesystem::create_directories(distances_directory(room, DistanceKind::kGiven));
  }
  const Grid grid = synthetic_grid(spec);
  for (const Line& line : grid.lines) {
    write_rays(spec, line, line_volume_path(room, line.id));
    if (spec.distances) write_distances(spec, line, distance_volume_path(room, line.id));
  }
  const PanoramaSize size{spec.width, spec.width / 2};
  write_file_atomically(
      manifest_path(room),
      manifest_to_json(
          {size, grid, {}, spec.distances ? DistanceKind::kGiven : DistanceKind::kNone}));
}

void remove_distances(const std::filesystem::path& room, const std::string& line) {
  Hdf5File file = Hdf5File::create(distance_volume_path(room, line));
  file.write_format(kDistanceVolumeFormat);
  file.write("station", std::vector<std::int32_t>());
  file.close();
}

cv::Mat render_truth(const SyntheticRoomSpec& spec, PlanPoint viewpoint, int width) {
  return render_scene(spec.scene, {viewpoint.x_m, spec.height_m, viewpoint.z_m}, width);
}

}  // namespace raywalk
