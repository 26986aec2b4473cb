#include "core/reconstruction/colmap_model.h"

#include <limits>
#include <unordered_map>

#include "core/files/atomic_output.h"
#include "core/reconstruction/colmap_bytes.h"

namespace raywalk {
namespace {

constexpr std::int32_t kPinhole = 1;       // COLMAP's number of the camera model fx, fy, cx, cy
constexpr std::int32_t kCameraSensor = 0;  // COLMAP's number of the kind of sensor

constexpr const char* kCameras = "cameras.bin";
constexpr const char* kImages = "images.bin";
constexpr const char* kPoints = "points3D.bin";
constexpr const char* kRigs = "rigs.bin";
constexpr const char* kFrames = "frames.bin";

ColmapByteReader opened(const std::filesystem::path& file) {
  return {read_file(file, std::numeric_limits<std::uint32_t>::max()), file.string()};
}

std::string camera_bytes(const std::vector<ColmapCamera>& cameras) {
  ColmapBytes out;
  out.put_count(cameras.size());
  for (const ColmapCamera& camera : cameras) {
    out.put(camera.id);
    out.put(kPinhole);
    out.put(static_cast<std::uint64_t>(camera.side_px));
    out.put(static_cast<std::uint64_t>(camera.side_px));
    const double middle = 0.5 * camera.side_px;
    for (const double value : {camera.focal_px, camera.focal_px, middle, middle}) out.put(value);
  }
  return out.bytes();
}

std::string image_bytes(const std::vector<ColmapImage>& images) {
  ColmapBytes out;
  out.put_count(images.size());
  for (const ColmapImage& image : images) {
    out.put(image.id);
    out.put_pose(image.pose);
    out.put(image.camera);
    out.put_text(image.name);
    out.put_count(image.features.size());
    for (const ColmapFeature& feature : image.features) {
      out.put(feature.pixel.x);
      out.put(feature.pixel.y);
      out.put(feature.point);
    }
  }
  return out.bytes();
}

std::string point_bytes(const std::vector<ColmapPoint>& points) {
  ColmapBytes out;
  out.put_count(points.size());
  for (const ColmapPoint& point : points) {
    out.put(point.id);
    for (const double value : point.position) out.put(value);
    for (const std::uint8_t channel : point.color) out.put(channel);
    out.put(point.error_px);
    out.put_count(point.track.size());
    for (const ColmapTrackElement& element : point.track) {
      out.put(element.image);
      out.put(element.feature);
    }
  }
  return out.bytes();
}

std::string rig_bytes(const std::vector<ColmapRig>& rigs) {
  ColmapBytes out;
  out.put_count(rigs.size());
  for (const ColmapRig& rig : rigs) {
    out.put(rig.id);
    out.put(static_cast<std::uint32_t>(1 + rig.others.size()));
    out.put(kCameraSensor);
    out.put(rig.reference_camera);
    for (const ColmapSensor& sensor : rig.others) {
      out.put(kCameraSensor);
      out.put(sensor.camera);
      out.put(std::uint8_t{1});  // the pose is known
      out.put_pose(sensor.from_rig);
    }
  }
  return out.bytes();
}

std::string frame_bytes(const ColmapModel& model) {
  std::unordered_map<std::uint32_t, std::uint32_t> camera_of;
  for (const ColmapImage& image : model.images) camera_of[image.id] = image.camera;
  ColmapBytes out;
  out.put_count(model.frames.size());
  for (const ColmapFrame& frame : model.frames) {
    out.put(frame.id);
    out.put(frame.rig);
    out.put_pose(frame.from_world);
    out.put(static_cast<std::uint32_t>(frame.images.size()));
    for (const std::uint32_t image : frame.images) {
      out.put(kCameraSensor);
      out.put(camera_of.at(image));
      out.put(static_cast<std::uint64_t>(image));
    }
  }
  return out.bytes();
}

std::vector<ColmapCamera> read_cameras(const std::filesystem::path& file) {
  ColmapByteReader in = opened(file);
  std::vector<ColmapCamera> cameras(in.take_count(56));
  for (ColmapCamera& camera : cameras) {
    camera.id = in.take<std::uint32_t>();
    if (in.take<std::int32_t>() != kPinhole) in.fail("a camera is not a pinhole");
    const auto width = in.take<std::uint64_t>();
    const auto height = in.take<std::uint64_t>();
    camera.focal_px = in.take_number();
    const double focal_y_px = in.take_number();
    const double middle_x = in.take_number();
    const double middle_y = in.take_number();
    const double middle = 0.5 * static_cast<double>(width);
    if (width != height || width > 100000 || focal_y_px != camera.focal_px || middle_x != middle ||
        middle_y != middle) {
      in.fail("a camera was not written by Raywalk");
    }
    camera.side_px = static_cast<int>(width);
  }
  in.require_end();
  return cameras;
}

std::vector<ColmapImage> read_images(const std::filesystem::path& file) {
  ColmapByteReader in = opened(file);
  std::vector<ColmapImage> images(in.take_count(73));
  for (ColmapImage& image : images) {
    image.id = in.take<std::uint32_t>();
    image.pose = in.take_pose();
    image.camera = in.take<std::uint32_t>();
    image.name = in.take_text();
    image.features.resize(in.take_count(24));
    for (ColmapFeature& feature : image.features) {
      feature.pixel.x = in.take_number();
      feature.pixel.y = in.take_number();
      feature.point = in.take<std::uint64_t>();
    }
  }
  in.require_end();
  return images;
}

std::vector<ColmapPoint> read_points(const std::filesystem::path& file,
                                     const std::vector<ColmapImage>& images) {
  std::unordered_map<std::uint32_t, std::size_t> feature_count;
  for (const ColmapImage& image : images) feature_count[image.id] = image.features.size();
  ColmapByteReader in = opened(file);
  std::vector<ColmapPoint> points(in.take_count(51));
  for (ColmapPoint& point : points) {
    point.id = in.take<std::uint64_t>();
    point.position = in.take_vector();
    for (std::uint8_t& channel : point.color) channel = in.take<std::uint8_t>();
    point.error_px = in.take<double>();
    point.track.resize(in.take_count(8));
    for (ColmapTrackElement& element : point.track) {
      element.image = in.take<std::uint32_t>();
      element.feature = in.take<std::uint32_t>();
      const auto image = feature_count.find(element.image);
      if (image == feature_count.end() || element.feature >= image->second) {
        in.fail("a point refers to a feature that does not exist");
      }
    }
  }
  in.require_end();
  return points;
}

}  // namespace

void write_colmap_model(const std::filesystem::path& directory, const ColmapModel& model) {
  write_file_atomically(directory / kCameras, camera_bytes(model.cameras));
  write_file_atomically(directory / kImages, image_bytes(model.images));
  write_file_atomically(directory / kPoints, point_bytes(model.points));
  if (model.rigs.empty()) return;
  write_file_atomically(directory / kRigs, rig_bytes(model.rigs));
  write_file_atomically(directory / kFrames, frame_bytes(model));
}

ColmapModel read_colmap_model(const std::filesystem::path& directory) {
  ColmapModel model;
  model.cameras = read_cameras(directory / kCameras);
  model.images = read_images(directory / kImages);
  model.points = read_points(directory / kPoints, model.images);
  return model;
}

}  // namespace raywalk
