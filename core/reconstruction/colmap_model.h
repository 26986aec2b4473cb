// COLMAP's sparse models: cameras, images, points, and the rigs and frames that COLMAP has
// from 3.12 on. Older versions read only the first three files and leave the others alone.
//
// Formats: colmap.github.io/format.html; of rigs and frames also COLMAP's
// src/colmap/scene/reconstruction_io_binary.cc.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/reconstruction/colmap_pose.h"
#include "core/reconstruction/panorama_faces.h"

namespace raywalk {

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
  std::string name{};        // relative to COLMAP's folder of images, with '/'
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
  std::array<std::uint8_t, 3> color{0, 0, 0};  // red, green, blue
  double error_px = 0.0;                       // mean distance of its observations; 0: not computed
};

// Cameras that are fixed to each other.
struct ColmapSensor {
  std::uint32_t camera = 0;  // id
  ColmapPose from_rig{};     // x_sensor = pose(x_rig)
};
struct ColmapRig {
  std::uint32_t id = 0;
  std::uint32_t reference_camera = 0;  // its frame is the rig's
  std::vector<ColmapSensor> others{};
};

// The images that a rig took at once.
struct ColmapFrame {
  std::uint32_t id = 0;
  std::uint32_t rig = 0;                // id
  ColmapPose from_world{};              // x_rig = pose(x_world)
  std::vector<std::uint32_t> images{};  // ids
};

struct ColmapModel {
  std::vector<ColmapCamera> cameras{};
  std::vector<ColmapImage> images{};
  std::vector<ColmapPoint> points{};
  // Without rigs their files are not written.
  std::vector<ColmapRig> rigs{};
  std::vector<ColmapFrame> frames{};
};

// Writes the binary files into an existing directory. Throws Error if it cannot.
void write_colmap_model(const std::filesystem::path& directory, const ColmapModel& model);

// Reads images.bin and points3D.bin. Throws Error naming the file if it is missing, truncated, has
// extra bytes, a non-finite number, or a track of an image or feature that does not exist.
ColmapModel read_colmap_model(const std::filesystem::path& directory);

// The images of a model of any camera and any version of COLMAP, from images.bin, or images.txt,
// without features, where there is none. Throws Error naming the file, and the line of a text, if
// there is none of the two, it is damaged, has no image, or one twice.
std::vector<ColmapImage> read_colmap_images(const std::filesystem::path& directory);

// The same of the contents of images.bin and images.txt; `source` names them in errors.
std::vector<ColmapImage> colmap_images_of_bytes(std::string bytes, const std::string& source);
std::vector<ColmapImage> colmap_images_of_text(const std::string& text, const std::string& source);

// Whether the first camera of a model is EQUIRECTANGULAR, which COLMAP 4.1 and newer have: its
// images are then panoramas, with the axes of a face that looks ahead. Throws Error naming
// cameras.bin if it is damaged.
bool images_are_panoramas(const std::filesystem::path& directory);

}  // namespace raywalk
