// Panoramas of 16384 x 8192 pixels: 400 MB each, offsets that take 29 bits.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"
#include "core/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kPanorama{16384, 8192};
constexpr PanoramaSize kMap{64, 32};
constexpr std::size_t kColumnBytes = 3 * std::size_t{kPanorama.height};
constexpr double kGigabyte = 1e9;

double available_memory_bytes() {
  std::ifstream info("/proc/meminfo");
  for (std::string word; info >> word;) {
    double kilobytes = 0.0;
    if (word == "MemAvailable:" && info >> kilobytes) return kilobytes * 1024.0;
  }
  return std::numeric_limits<double>::infinity();
}

// The colour at infinity in the direction of a pixel. Neighbouring pixels differ by at most one
// level, which bounds the effect of rounding; green and blue distinguish columns and rows over the
// whole picture.
struct Color {
  std::uint8_t red, green, blue;
};
Color color_at(int u, int v) {
  const int wave = std::abs((u + v) % 510 - 255);
  const int turn = std::abs(u - kPanorama.width / 2) / 32;
  return {static_cast<std::uint8_t>(wave), static_cast<std::uint8_t>(std::min(turn, 255)),
          static_cast<std::uint8_t>(v / 32)};
}

template <typename Value>
void write_copies(Hdf5File* file, const char* name, hid_t type, PanoramaSize size, int depth,
                  const std::vector<Value>& slab) {
  std::vector<std::size_t> shape{2, static_cast<std::size_t>(size.width),
                                 static_cast<std::size_t>(size.height)};
  if (depth > 1) shape.push_back(static_cast<std::size_t>(depth));
  const Hdf5Handle dataset = file->create_contiguous(name, type, shape);
  for (std::size_t station = 0; station < 2; ++station) {
    file->write_slab(dataset, station, type, shape, slab.data());
  }
}

// One line of two stations that see an infinitely far scene.
Room write_large_room(const std::filesystem::path& directory) {
  SyntheticRoomSpec spec;
  spec.cells_z = 0;
  spec.spacing_m = 1.0;
  const Grid grid = synthetic_grid(spec);
  std::filesystem::create_directories(directory / "lines");
  std::filesystem::create_directories(directory / "distances");
  {
    std::vector<std::uint8_t> rays(kColumnBytes * std::size_t{kPanorama.width});
    std::uint8_t* out = rays.data();
    for (int u = 0; u < kPanorama.width; ++u) {
      for (int v = 0; v < kPanorama.height; ++v) {
        const Color color = color_at(u, v);
        *out++ = color.red;
        *out++ = color.green;
        *out++ = color.blue;
      }
    }
    Hdf5File file = Hdf5File::create(line_volume_path(directory, grid.lines[0].id));
    file.write_attribute("/", "format", kLineVolumeFormat);
    file.write_attribute("/", "format_version", kPlainVolumeVersion);
    write_copies(&file, "rays", H5T_NATIVE_UINT8, kPanorama, 3, rays);
    file.close();
  }
  const std::size_t pixels = std::size_t{kMap.width} * std::size_t{kMap.height};
  Hdf5File file = Hdf5File::create(distance_volume_path(directory, grid.lines[0].id));
  file.write_attribute("/", "format", kDistanceVolumeFormat);
  file.write_attribute("/", "format_version", kPlainVolumeVersion);
  file.write_int32("station", std::vector<std::int32_t>{0, 1});
  write_copies(&file, "distance_m", H5T_NATIVE_FLOAT, kMap, 1,
               std::vector<float>(pixels, std::numeric_limits<float>::infinity()));
  write_copies(&file, "confidence", H5T_NATIVE_UINT8, kMap, 1,
               std::vector<std::uint8_t>(pixels, 255));
  file.close();
  write_file_atomically(manifest_path(directory), manifest_to_json({kPanorama, grid, {}}));
  return Room::open(directory);
}

TEST(RendererLarge, PanoramasOf16384ColumnsAreReadAtTheRightPositions) {
  const TestDirectory directory;
  const double disk_bytes = static_cast<double>(std::filesystem::space(directory.path()).available);
  if (available_memory_bytes() < 3.0 * kGigabyte || disk_bytes < 2.0 * kGigabyte) {
    GTEST_SKIP() << "needs 3 GB of memory and 2 GB of disk";
  }
  const Room room = write_large_room(directory / "room.lf");
  for (const Generation generation : {Generation::kInitial, Generation::kHlfVd}) {
    // The line, 1 m long and 0.2 m ahead, serves 68 degrees to either side.
    const RenderedView view = Renderer(room, {.generation = generation}).render({0.0, -0.2});
    ASSERT_EQ(view.image.size(), cv::Size(kPanorama.width, kPanorama.height));
    EXPECT_NEAR(view.report.empty_share, 1.0 - 68.2 / 180.0, 0.001);
    constexpr int kServed = kPanorama.width * 68 / 360;
    int worst = 0;
    for (int u = kPanorama.width / 2 - kServed; u < kPanorama.width / 2 + kServed; u += 37) {
      for (int v = 0; v < kPanorama.height; ++v) {
        const cv::Vec3b bgr = view.image.at<cv::Vec3b>(v, u);
        const Color exact = color_at(u, v);
        worst = std::max({worst, std::abs(bgr[0] - exact.blue), std::abs(bgr[1] - exact.green),
                          std::abs(bgr[2] - exact.red)});
      }
    }
    EXPECT_LE(worst, 1) << generation_name(generation);
  }
}

}  // namespace
}  // namespace raywalk
