#include "calibrate/import/opensfm_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/reconstruction/z_up_axes.h"

namespace raywalk::calibrate {
namespace {

Eigen::Vector3d vector_of(const CheckedJson& list) {
  const std::vector<CheckedJson> numbers = list.items(3);
  return {numbers[0].number(), numbers[1].number(), numbers[2].number()};
}

void require_spherical(const CheckedJson& cameras, const std::string& camera) {
  const CheckedJson type = cameras.at(camera).at("projection_type");
  const std::string name = type.text();
  if (name == "spherical" || name == "equirectangular") return;
  type.fail(excerpt(name) + " is no camera of panoramas (spherical); give poses of panoramas");
}

CameraPose pose_of(const CheckedJson& shot) {
  const Eigen::Vector3d turn = vector_of(shot.at("rotation"));
  const double angle = turn.norm();
  const Eigen::Matrix3d camera_from_world =
      angle == 0.0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                   : Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  const Eigen::Matrix3d world_from_camera = camera_from_world.transpose();
  const Eigen::Vector3d centre = -world_from_camera * vector_of(shot.at("translation"));
  // y up instead of down in the camera.
  const Eigen::Matrix3d flip = Eigen::Vector3d(1, -1, 1).asDiagonal();
  return {z_up_axes(centre), z_up_matrix() * world_from_camera * flip};
}

CheckedJson largest_of(const CheckedJson& root, const std::string& source) {
  const std::vector<CheckedJson> all = root.items();
  if (all.empty()) root.fail("holds no reconstruction");
  std::size_t largest = 0;
  std::vector<std::size_t> shots;
  for (std::size_t i = 0; i < all.size(); ++i) {
    shots.push_back(all[i].at("shots").members().size());
    if (shots[i] > shots[largest]) largest = i;
  }
  if (all.size() > 1) {
    spdlog::warn(
        "{}: holds {} reconstructions that are not connected; the largest is used, of {} "
        "pictures",
        source, all.size(), shots[largest]);
  }
  return all[largest];
}

ImportedPoses poses_of(const CheckedJson& root, const std::filesystem::path& file) {
  const CheckedJson reconstruction = largest_of(root, file.string());
  const CheckedJson cameras = reconstruction.at("cameras");
  ImportedPoses poses{.kind = "OpenSfM's reconstruction.json",
                      .panoramas = directory_of(file) / "images"};
  for (const auto& [name, shot] : reconstruction.at("shots").members()) {
    require_spherical(cameras, shot.at("camera").text());
    poses.frames.push_back({.file = name,
                            .pose = pose_of(shot),
                            .where = fmt::format("{}: shot {}", file.string(), excerpt(name))});
  }
  if (poses.frames.empty()) reconstruction.fail("holds no shots");
  return poses;
}

}  // namespace

ImportedPoses opensfm_of_text(const std::string& text, const std::filesystem::path& file) {
  return poses_of(CheckedJson::parse(text, file.string()), file);
}

ImportedPoses read_opensfm(const std::filesystem::path& file) {
  return poses_of(CheckedJson::read(file), file);
}

}  // namespace raywalk::calibrate
