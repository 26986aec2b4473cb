// Panoramas of 16384 x 8192 pixels: 400 MB each, and the last of a line beyond 2 GB.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"
#include "core/view/renderer.h"
#include "core/view/test_viewport.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kPanorama{16384, 8192};
constexpr PanoramaSize kMap{64, 32};

// The colour at infinity in the direction of a pixel. Neighbouring pixels differ by at most one
// level, which bounds the effect of rounding; green and blue distinguish columns and rows over the
// whole picture.
struct Color {
  std::uint8_t red, green, blue;
};
Color color_at(int u, int v) {
  const int aside = std::abs(u - kPanorama.width / 2);  // the same on both sides of the seam
  const int wave = std::abs((aside + v) % 510 - 255);
  const int turn = aside / 32;
  return {static_cast<std::uint8_t>(wave), static_cast<std::uint8_t>(std::min(turn, 255)),
          static_cast<std::uint8_t>(v / 32)};
}

// A dataset of which only the last station's values are written; the file has a hole before them.
template <typename Value>
void write_last(Hdf5File* file, const char* name, ElementType type, const Shape& shape,
                const std::vector<Value>& slab) {
  file->create_contiguous(name, type, shape);
  file->write_slab(name, shape.front() - 1, slab.data());
}

// One line of seven stations that see an infinitely far scene.
Room write_large_room(const std::filesystem::path& directory) {
  SyntheticRoomSpec spec;
  spec.cells_z = 0;
  spec.spacing_m = 1.0 / 6.0;
  const Grid grid = synthetic_grid(spec);
  std::filesystem::create_directories(directory / "lines");
  std::filesystem::create_directories(distances_directory(directory, DistanceKind::kGiven));
  {
    std::vector<std::uint8_t> rays;
    rays.reserve(std::size_t{3} * kPanorama.width * kPanorama.height);
    for (int u = 0; u < kPanorama.width; ++u) {
      for (int v = 0; v < kPanorama.height; ++v) {
        const Color color = color_at(u, v);
        rays.insert(rays.end(), {color.red, color.green, color.blue});
      }
    }
    Hdf5File file = Hdf5File::create(line_volume_path(directory, grid.lines[0].id));
    file.write_format(kLineVolumeFormat);
    write_last(&file, "rays", ElementType::kUint8, {7, kPanorama.width, kPanorama.height, 3}, rays);
    file.close();
  }
  const std::size_t pixels = std::size_t{kMap.width} * std::size_t{kMap.height};
  Hdf5File file = Hdf5File::create(distance_volume_path(directory, grid.lines[0].id));
  file.write_format(kDistanceVolumeFormat);
  file.write("station", std::vector<std::int32_t>{6});
  write_last(&file, "distance_m", ElementType::kFloat32, {1, kMap.width, kMap.height},
             std::vector<float>(pixels, std::numeric_limits<float>::infinity()));
  write_last(&file, "confidence", ElementType::kUint8, {1, kMap.width, kMap.height},
             std::vector<std::uint8_t>(pixels, 255));
  file.close();
  write_file_atomically(manifest_path(directory),
                        manifest_to_json({kPanorama, grid, {}, DistanceKind::kGiven}));
  return Room::open(directory);
}

TEST(RendererLarge, PanoramasOf16384ColumnsAreReadAtTheRightPositions) {
  const TestDirectory directory;
  const double disk_bytes = static_cast<double>(std::filesystem::space(directory.path()).available);
  if (disk_bytes < 1e9) GTEST_SKIP() << "needs 1 GB of disk";
  const Room room = write_large_room(directory / "room.lf");
  for (const ViewMethod method : {ViewMethod::kInitial, ViewMethod::kHlfVd}) {
    // From the last station, which is read in all directions: ahead, across the seam, to the last
    // rows.
    Renderer renderer(room, {.method = method});
    for (const auto& [yaw_deg, pitch_deg] :
         {std::pair{0.3, 0.2}, {-180.0, 5.0}, {179.0, -83.0}, {-70.0, 88.0}}) {
      // About as fine as the panorama.
      const Viewport viewport = looking(yaw_deg, pitch_deg, 10.0, 2.2, 100, 80);
      const cv::Mat picture = renderer.render({0.5, 0.0}, viewport).image;
      int worst = 0;
      for (int v = 0; v < picture.rows; ++v) {
        for (int u = 0; u < picture.cols; ++u) {
          const cv::Vec3b bgr = picture.at<cv::Vec3b>(v, u);
          const PixelPosition at =
              pixel_from_angles(angles_from_direction(ray_of(viewport, u, v)), kPanorama);
          const Color exact = color_at(static_cast<int>(std::lround(at.u)) % kPanorama.width,
                                       static_cast<int>(std::lround(at.v)));
          worst = std::max({worst, std::abs(bgr[0] - exact.blue), std::abs(bgr[1] - exact.green),
                            std::abs(bgr[2] - exact.red)});
        }
      }
      EXPECT_LE(worst, 2) << method_name(method) << " yaw " << yaw_deg;
    }
  }
}

}  // namespace
}  // namespace raywalk
