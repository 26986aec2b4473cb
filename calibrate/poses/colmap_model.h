// COLMAP's sparse models in their binary format: cameras.bin, images.bin, points3D.bin
// (colmap.github.io/format.html, "Binary file format"; little-endian, no padding).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/poses/panorama_faces.h"

namespace raywalk::calibrate {

// A pinhole camera with square pixels and the principal point in the middle of its picture.
struct ColmapCamera {
  std::uint32_t id = 0;
  int side_px = 0;  // width and height
  double focal_px = 0.0;
};

// A feature of an image, COLMAP's pixels; `point` is an id in ColmapModel::points or kNoPoint.
struct ColmapFeature {
  FacePixel pixel{};
  std::uint64_t point = 0;
};
inline constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};

struct ColmapImage {
  std::uint32_t id = 0;
  std::uint32_t camera = 0;  // id
  std::string name{};
  ColmapPose pose{};
  std::vector<ColmapFeature> features{};
};

// An observation of a point.
struct ColmapTrackElement {
  std::uint32_t image = 0;    // id
  std::uint32_t feature = 0;  // index into ColmapImage::features
};

struct ColmapPoint {
  std::uint64_t id = 0;
  Eigen::Vector3d position{0, 0, 0};  // COLMAP's world
  std::vector<ColmapTrackElement> track{};
};

struct ColmapModel {
  std::vector<ColmapCamera> cameras{};
  std::vector<ColmapImage> images{};
  std::vector<ColmapPoint> points{};
};

// Writes the three files into an existing directory. Throws Error if it cannot.
void write_colmap_model(const std::filesystem::path& directory, const ColmapModel& model);

// Throws Error naming the file if it is missing, truncated, has extra bytes, a camera of another
// model, a non-finite number, or a track of an image or feature that does not exist.
ColmapModel read_colmap_model(const std::filesystem::path& directory);

}  // namespace raywalk::calibrate
