#include "calibrate/import/face_poses.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "calibrate/base/frame_poses.h"
#include "calibrate/base/rotation.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/csv.h"
#include "core/files/frame_list.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr double kMostTurn_deg = 5.0;

std::string folders_of(const std::vector<NamedFace>& faces) {
  std::vector<std::string> folders;
  folders.reserve(faces.size());
  for (const NamedFace& face : faces) folders.push_back(face.folder);
  return fmt::format("{}", fmt::join(folders, ", "));
}

// The face whose folder an image is in, and the rest of its name.
struct FaceImage {
  const NamedFace* face = nullptr;
  std::string panorama{};
};

FaceImage face_image_of(const std::string& name, const std::vector<NamedFace>& faces,
                        const fs::path& model) {
  for (const NamedFace& face : faces) {
    if (!name.starts_with(face.folder + "/")) continue;
    const fs::path rest = name.substr(face.folder.size() + 1);
    return {&face, (rest.parent_path() / rest.stem()).generic_string()};
  }
  throw Error(
      fmt::format("{}: image {} is in none of the folders of faces ({}); name the folders and the "
                  "angles of the "
                  "faces with --faces TABLE",
                  model.string(), excerpt(name), folders_of(faces)));
}

// The rotation that is nearest to all of them (least squares of their matrices).
Eigen::Matrix3d mean_rotation(const std::vector<CameraPose>& poses) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const CameraPose& pose : poses) sum += pose.world_from_camera;
  return nearest_rotation(sum);
}

CameraPose mean_pose(const std::vector<CameraPose>& poses) {
  CameraPose mean{.world_from_camera = mean_rotation(poses)};
  for (const CameraPose& pose : poses) {
    mean.position_m += pose.position_m / static_cast<double>(poses.size());
  }
  return mean;
}

struct FaceDisagreement {
  double turn_rad = 0.0;
  double distance = 0.0;
};

FaceDisagreement disagreement_of(const std::vector<CameraPose>& poses, const CameraPose& mean) {
  FaceDisagreement most;
  for (const CameraPose& pose : poses) {
    most.turn_rad =
        std::max(most.turn_rad, angle_between(pose.world_from_camera, mean.world_from_camera));
    most.distance = std::max(most.distance, (pose.position_m - mean.position_m).norm());
  }
  return most;
}

// The median distance to the nearest panorama at another place; two lines may have one each where
// they cross.
double median_spacing(const std::vector<ImportedFrame>& frames, double same_place) {
  std::vector<double> nearest;
  for (const ImportedFrame& frame : frames) {
    double least = std::numeric_limits<double>::infinity();
    for (const ImportedFrame& other : frames) {
      const double distance = (other.pose.position_m - frame.pose.position_m).norm();
      if (distance > same_place) least = std::min(least, distance);
    }
    if (std::isfinite(least)) nearest.push_back(least);
  }
  return nearest.empty() ? std::numeric_limits<double>::infinity() : median(std::move(nearest));
}

double extent_of(const std::vector<ImportedFrame>& frames) {
  double extent = 0.0;
  for (const ImportedFrame& frame : frames) {
    extent = std::max(extent, (frame.pose.position_m - frames.front().pose.position_m).norm());
  }
  return extent;
}

void require_agreement(const std::vector<ImportedFrame>& frames,
                       const std::vector<FaceDisagreement>& disagreements, const fs::path& model) {
  const double spacing = median_spacing(frames, 1e-3 * extent_of(frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double turn_deg = degrees_from_radians(disagreements[i].turn_rad);
    if (turn_deg > kMostTurn_deg) {
      throw Error(fmt::format(
          "{}: the faces of panorama {} disagree by {:.1f} degrees about its attitude; are their "
          "angles those of --faces?",
          model.string(), excerpt(frames[i].file), turn_deg));
    }
    if (disagreements[i].distance > 0.5 * spacing) {
      throw Error(
          fmt::format("{}: the faces of panorama {} are at places {:.3g} apart, while panoramas "
                      "are {:.3g} apart "
                      "(in the model's unit); reconstruct it with the faces fixed to each other",
                      model.string(), excerpt(frames[i].file), disagreements[i].distance, spacing));
    }
  }
}

}  // namespace

std::vector<NamedFace> exported_faces() {
  std::vector<NamedFace> faces;
  faces.reserve(kCubeFaces.size());
  for (const CubeFace& face : kCubeFaces) {
    faces.push_back({face.name, world_from_camera(face.attitude)});
  }
  return faces;
}

std::vector<NamedFace> read_face_table(const fs::path& file) {
  const CsvTable table = CsvTable::read(file, {"folder", "yaw", "pitch"}, {"roll"});
  std::vector<NamedFace> faces;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string folder = table.text(row, "folder");
    if (folder.empty()) throw Error(table.where(row) + ": names no folder");
    faces.push_back({folder, world_from_camera(read_attitude(table, row))});
  }
  if (faces.empty()) throw Error(file.string() + ": lists no faces");
  return faces;
}

std::vector<ImportedFrame> panoramas_of_faces(const std::vector<ColmapImage>& images,
                                              const std::vector<NamedFace>& faces,
                                              const fs::path& model) {
  std::map<std::string, std::vector<CameraPose>> seen;
  for (const ColmapImage& image : images) {
    const FaceImage of = face_image_of(image.name, faces, model);
    seen[of.panorama].push_back(camera_pose_of(image.pose, {of.face->camera_from_face}));
  }
  std::vector<ImportedFrame> frames;
  std::vector<FaceDisagreement> disagreements;
  for (const auto& [panorama, poses] : seen) {
    const CameraPose mean = mean_pose(poses);
    disagreements.push_back(disagreement_of(poses, mean));
    frames.push_back({.file = panorama,
                      .pose = mean,
                      .where = fmt::format("{}: panorama {}", model.string(), excerpt(panorama))});
  }
  require_agreement(frames, disagreements, model);
  return frames;
}

}  // namespace raywalk::calibrate
