// The text format of COLMAP's models. Numbers have 17 digits, so that they are read exactly.
#include <fmt/format.h>

#include <iterator>
#include <unordered_map>

#include "core/files/atomic_output.h"
#include "core/reconstruction/colmap_model.h"

namespace raywalk {
namespace {

std::string pose_text(const ColmapPose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation;
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}", q.w(), q.x(), q.y(),
                     q.z(), t.x(), t.y(), t.z());
}

std::string camera_text(const std::vector<ColmapCamera>& cameras) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY\n";
  for (const ColmapCamera& camera : cameras) {
    text += fmt::format("{0} PINHOLE {1} {1} {2:.17g} {2:.17g} {3:.17g} {3:.17g}\n", camera.id,
                        camera.side_px, camera.focal_px, 0.5 * camera.side_px);
  }
  return text;
}

std::string image_text(const std::vector<ColmapImage>& images) {
  std::string text = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# X Y POINT3D_ID ...\n";
  auto out = std::back_inserter(text);
  for (const ColmapImage& image : images) {
    fmt::format_to(out, "{} {} {} {}\n", image.id, pose_text(image.pose), image.camera, image.name);
    for (const ColmapFeature& feature : image.features) {
      fmt::format_to(out, "{:.17g} {:.17g} ", feature.pixel.x, feature.pixel.y);
      if (feature.point == kNoPoint) {
        text += "-1 ";
      } else {
        fmt::format_to(out, "{} ", feature.point);
      }
    }
    if (!image.features.empty()) text.pop_back();
    text += '\n';
  }
  return text;
}

std::string point_text(const std::vector<ColmapPoint>& points) {
  std::string text = "# POINT3D_ID X Y Z R G B ERROR IMAGE_ID POINT2D_IDX ...\n";
  auto out = std::back_inserter(text);
  for (const ColmapPoint& point : points) {
    const Eigen::Vector3d& at = point.position;
    fmt::format_to(out, "{} {:.17g} {:.17g} {:.17g} {} {} {} {:.17g}", point.id, at.x(), at.y(),
                   at.z(), point.color[0], point.color[1], point.color[2], point.error_px);
    for (const ColmapTrackElement& element : point.track) {
      fmt::format_to(out, " {} {}", element.image, element.feature);
    }
    text += '\n';
  }
  return text;
}

std::string rig_text(const std::vector<ColmapRig>& rigs) {
  std::string text =
      "# RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID SENSOR_TYPE SENSOR_ID HAS_POSE QW QX QY "
      "QZ "
      "TX TY TZ ...\n";
  for (const ColmapRig& rig : rigs) {
    text += fmt::format("{} {} CAMERA {}", rig.id, 1 + rig.others.size(), rig.reference_camera);
    for (const ColmapSensor& sensor : rig.others) {
      text += fmt::format(" CAMERA {} 1 {}", sensor.camera, pose_text(sensor.from_rig));
    }
    text += '\n';
  }
  return text;
}

std::string frame_text(const ColmapModel& model) {
  std::unordered_map<std::uint32_t, std::uint32_t> camera_of;
  for (const ColmapImage& image : model.images) camera_of[image.id] = image.camera;
  std::string text =
      "# FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA_IDS SENSOR_TYPE SENSOR_ID DATA_ID ...\n";
  for (const ColmapFrame& frame : model.frames) {
    text += fmt::format("{} {} {} {}", frame.id, frame.rig, pose_text(frame.from_world),
                        frame.images.size());
    for (const std::uint32_t image : frame.images) {
      text += fmt::format(" CAMERA {} {}", camera_of.at(image), image);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

void write_colmap_text(const std::filesystem::path& directory, const ColmapModel& model) {
  write_file_atomically(directory / "cameras.txt", camera_text(model.cameras));
  write_file_atomically(directory / "images.txt", image_text(model.images));
  write_file_atomically(directory / "points3D.txt", point_text(model.points));
  if (model.rigs.empty()) return;
  write_file_atomically(directory / "rigs.txt", rig_text(model.rigs));
  write_file_atomically(directory / "frames.txt", frame_text(model));
}

}  // namespace raywalk
