#include "calibrate/poses/colmap_model.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>
#include <unordered_map>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::calibrate {
namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP's files are little-endian");

constexpr std::int32_t kPinhole = 1;  // COLMAP's number of the camera model fx, fy, cx, cy

constexpr const char* kCameras = "cameras.bin";
constexpr const char* kImages = "images.bin";
constexpr const char* kPoints = "points3D.bin";

class ByteWriter {
 public:
  template <typename Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<char, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(Number));
    bytes_.append(bytes.data(), bytes.size());
  }
  void put_text(const std::string& text) { bytes_.append(text).push_back('\0'); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_{};
};

class ByteReader {
 public:
  explicit ByteReader(const std::filesystem::path& file)
      : file_(file), bytes_(read_file(file, std::numeric_limits<std::uint32_t>::max())) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fmt::format("{}: {}; it is not a COLMAP model", file_.string(), what));
  }

  template <typename Number>
  Number take() {
    if (bytes_.size() - at_ < sizeof(Number)) fail("cut short");
    Number number{};
    std::memcpy(&number, bytes_.data() + at_, sizeof(Number));
    at_ += sizeof(Number);
    return number;
  }

  double take_number() {
    const auto number = take<double>();
    if (!std::isfinite(number)) fail("a coordinate is not a finite number");
    return number;
  }

  Eigen::Vector3d take_vector() {
    const double x = take_number();
    const double y = take_number();
    return {x, y, take_number()};
  }

  // The number of elements that follow. Each takes at least `element_bytes`, which bounds a damaged
  // count by the size of the file.
  std::size_t take_count(std::size_t element_bytes) {
    const auto count = take<std::uint64_t>();
    if (count > (bytes_.size() - at_) / element_bytes) fail("cut short");
    return static_cast<std::size_t>(count);
  }

  std::string take_text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("cut short");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return text;
  }

  void require_end() const {
    if (at_ != bytes_.size()) fail("bytes are left over at its end");
  }

 private:
  std::filesystem::path file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

std::string camera_bytes(const std::vector<ColmapCamera>& cameras) {
  ByteWriter out;
  out.put(static_cast<std::uint64_t>(cameras.size()));
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
  ByteWriter out;
  out.put(static_cast<std::uint64_t>(images.size()));
  for (const ColmapImage& image : images) {
    out.put(image.id);
    const Eigen::Quaterniond& rotation = image.pose.rotation;
    for (const double value : {rotation.w(), rotation.x(), rotation.y(), rotation.z()}) {
      out.put(value);
    }
    for (const double value : image.pose.translation) out.put(value);
    out.put(image.camera);
    out.put_text(image.name);
    out.put(static_cast<std::uint64_t>(image.features.size()));
    for (const ColmapFeature& feature : image.features) {
      out.put(feature.pixel.x);
      out.put(feature.pixel.y);
      out.put(feature.point);
    }
  }
  return out.bytes();
}

std::string point_bytes(const std::vector<ColmapPoint>& points) {
  ByteWriter out;
  out.put(static_cast<std::uint64_t>(points.size()));
  for (const ColmapPoint& point : points) {
    out.put(point.id);
    for (const double value : point.position) out.put(value);
    for (int channel = 0; channel < 3; ++channel) out.put(std::uint8_t{0});
    out.put(0.0);  // its error, which COLMAP recomputes
    out.put(static_cast<std::uint64_t>(point.track.size()));
    for (const ColmapTrackElement& element : point.track) {
      out.put(element.image);
      out.put(element.feature);
    }
  }
  return out.bytes();
}

std::vector<ColmapCamera> read_cameras(const std::filesystem::path& file) {
  ByteReader in(file);
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
      in.fail("a camera was not written by raywalk-calibrate");
    }
    camera.side_px = static_cast<int>(width);
  }
  in.require_end();
  return cameras;
}

ColmapPose take_pose(ByteReader* in) {
  const double w = in->take_number();
  const Eigen::Vector3d xyz = in->take_vector();
  const Eigen::Quaterniond rotation(w, xyz.x(), xyz.y(), xyz.z());
  if (rotation.norm() < 0.5) in->fail("a rotation is not a quaternion");
  return {rotation.normalized(), in->take_vector()};
}

std::vector<ColmapImage> read_images(const std::filesystem::path& file) {
  ByteReader in(file);
  std::vector<ColmapImage> images(in.take_count(73));
  for (ColmapImage& image : images) {
    image.id = in.take<std::uint32_t>();
    image.pose = take_pose(&in);
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
  ByteReader in(file);
  std::vector<ColmapPoint> points(in.take_count(51));
  for (ColmapPoint& point : points) {
    point.id = in.take<std::uint64_t>();
    point.position = in.take_vector();
    for (int channel = 0; channel < 3; ++channel) in.take<std::uint8_t>();
    in.take<double>();
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
}

ColmapModel read_colmap_model(const std::filesystem::path& directory) {
  ColmapModel model;
  model.cameras = read_cameras(directory / kCameras);
  model.images = read_images(directory / kImages);
  model.points = read_points(directory / kPoints, model.images);
  return model;
}

}  // namespace raywalk::calibrate
