#include "core/reconstruction/colmap_model.h"

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/words.h"
#include "core/reconstruction/colmap_bytes.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::numeric_limits<std::uint32_t>::max();
constexpr std::int32_t kPinhole = 1;  // COLMAP's number of the camera model fx, fy, cx, cy
constexpr std::int32_t kEquirectangular = 17;
constexpr std::int32_t kCameraSensor = 0;  // COLMAP's number of the kind of sensor

constexpr const char* kCameras = "cameras.bin";
constexpr const char* kImages = "images.bin";
constexpr const char* kPoints = "points3D.bin";
constexpr const char* kRigs = "rigs.bin";
constexpr const char* kFrames = "frames.bin";

ColmapByteReader opened(const fs::path& file) {
  return {read_file(file, kMostBytes), file.string()};
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

std::vector<ColmapImage> images_of(ColmapByteReader in) {
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

std::vector<ColmapPoint> read_points(const fs::path& file, const std::vector<ColmapImage>& images) {
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

void require_images(const std::vector<ColmapImage>& images, const std::string& source) {
  if (images.empty()) throw Error(source + ": holds no image; COLMAP has not registered any");
  std::set<std::string> names;
  for (const ColmapImage& image : images) {
    if (image.name.empty()) throw Error(source + ": an image has no name");
    if (!names.insert(image.name).second) {
      throw Error(fmt::format("{}: image {} is there twice", source, excerpt(image.name)));
    }
  }
}

bool next_line(std::istream* text, std::string* line) {
  if (!std::getline(*text, *line)) return false;
  if (line->ends_with('\r')) line->pop_back();
  return true;
}

// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME; the name may hold spaces.
ColmapImage image_of(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  const auto number = [&] {
    std::string word;
    words >> word;
    if (const std::optional<double> value = parse_finite_number(word)) return *value;
    throw Error(
        fmt::format("{}: {} is not a number; expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME",
                    where, excerpt(word)));
  };
  number();  // id
  const double w = number(), x = number(), y = number(), z = number();
  const Eigen::Quaterniond rotation(w, x, y, z);
  if (!(rotation.norm() > 0.5 && rotation.norm() < 2.0)) {
    throw Error(where + ": the rotation is not a quaternion; the model is damaged");
  }
  const double tx = number(), ty = number(), tz = number();
  number();  // camera
  ColmapImage image{.pose = {rotation.normalized(), {tx, ty, tz}}};
  std::getline(words >> std::ws, image.name);
  return image;
}

}  // namespace

void write_colmap_model(const fs::path& directory, const ColmapModel& model) {
  write_file_atomically(directory / kCameras, camera_bytes(model.cameras));
  write_file_atomically(directory / kImages, image_bytes(model.images));
  write_file_atomically(directory / kPoints, point_bytes(model.points));
  if (model.rigs.empty()) return;
  write_file_atomically(directory / kRigs, rig_bytes(model.rigs));
  write_file_atomically(directory / kFrames, frame_bytes(model));
}

ColmapModel read_colmap_model(const fs::path& directory) {
  ColmapModel model;
  model.images = images_of(opened(directory / kImages));
  model.points = read_points(directory / kPoints, model.images);
  return model;
}

std::vector<ColmapImage> colmap_images_of_bytes(std::string bytes, const std::string& source) {
  std::vector<ColmapImage> images = images_of({std::move(bytes), source});
  require_images(images, source);
  return images;
}

std::vector<ColmapImage> colmap_images_of_text(const std::string& text, const std::string& source) {
  std::vector<ColmapImage> images;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; next_line(&lines, &line); ++number) {
    if (line.empty() || line.starts_with('#')) continue;
    images.push_back(image_of(line, fmt::format("{}:{}", source, number)));
    next_line(&lines, &line);  // its features, perhaps none
    ++number;
  }
  require_images(images, source);
  return images;
}

std::vector<ColmapImage> read_colmap_images(const fs::path& directory) {
  const fs::path binary = directory / kImages;
  if (fs::exists(binary))
    return colmap_images_of_bytes(read_file(binary, kMostBytes), binary.string());
  const fs::path text = directory / "images.txt";
  if (fs::exists(text)) return colmap_images_of_text(read_file(text, kMostBytes), text.string());
  throw Error(directory.string() +
              ": holds neither images.bin nor images.txt; give the folder of a COLMAP model, such "
              "as sparse/0");
}

// A camera is ID MODEL WIDTH HEIGHT PARAMETERS.
bool images_are_panoramas(const fs::path& directory) {
  const fs::path binary = directory / kCameras;
  if (fs::exists(binary)) {
    ColmapByteReader in = opened(binary);
    if (in.take<std::uint64_t>() == 0) return false;
    in.take<std::uint32_t>();
    return in.take<std::int32_t>() == kEquirectangular;
  }
  if (!fs::exists(directory / "cameras.txt")) return false;
  std::istringstream lines(read_file(directory / "cameras.txt", kMostBytes));
  for (std::string line, id, model; next_line(&lines, &line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::istringstream(line) >> id >> model;
    return model == "EQUIRECTANGULAR";
  }
  return false;
}

}  // namespace raywalk
