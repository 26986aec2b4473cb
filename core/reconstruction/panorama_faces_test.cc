#include "core/reconstruction/panorama_faces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/reconstruction/colmap_pose.h"

namespace raywalk {
namespace {

constexpr int kFace_px = 64;

Eigen::Vector3d random_point(std::mt19937* random, double most) {
  std::uniform_real_distribution<double> value(-most, most);
  const double x = value(*random), y = value(*random);
  return {x, y, value(*random)};
}

CameraPose some_pose(unsigned seed) {
  std::mt19937 random(seed);
  const Eigen::Vector3d angles = random_point(&random, 3.0);
  return {random_point(&random, 3.0),
          world_from_camera({angles.x(), 0.5 * angles.y(), angles.z()})};
}

// A face that looks up, aslant and rolled, beside the camera's centre.
PanoramaFace some_face() { return {world_from_camera({0.8, 0.4, -0.3}), {0.001, 0.002, 0.006}}; }

// COLMAP's own way, by its documentation: rotate by the quaternion, add t, divide, scale.
FacePixel colmap_projection(const ColmapPose& pose, const Eigen::Vector3d& colmap_world) {
  const Eigen::Vector3d in_image = pose.rotation * colmap_world + pose.translation;
  const double focal = 0.5 * kFace_px;
  return {focal * in_image.x() / in_image.z() + 0.5 * kFace_px,
          focal * in_image.y() / in_image.z() + 0.5 * kFace_px};
}

TEST(PanoramaFaces, ProjectAsColmapDoes) {
  std::vector<PanoramaFace> faces = cube_faces();
  faces.push_back(some_face());
  for (unsigned seed = 0; seed < 50; ++seed) {
    const CameraPose camera = some_pose(seed);
    std::mt19937 random(1000 + seed);
    const Eigen::Vector3d world = camera.position_m + random_point(&random, 4.0);
    for (const PanoramaFace& face : faces) {
      const Eigen::Vector3d from_lens =
          camera.world_from_camera.transpose() * (world - camera.position_m) - face.centre_m;
      const auto ours = face_pixel_of(face, kFace_px, from_lens);
      const ColmapPose pose = colmap_pose(camera, face);
      const double depth = (pose.rotation * flipped(world) + pose.translation).z();
      EXPECT_EQ(ours.has_value(), depth > 0.0);
      if (!ours) continue;
      const FacePixel theirs = colmap_projection(pose, flipped(world));
      EXPECT_NEAR(ours->x, theirs.x, 1e-6 * std::max(1.0, std::abs(theirs.x)));
      EXPECT_NEAR(ours->y, theirs.y, 1e-6 * std::max(1.0, std::abs(theirs.y)));
      EXPECT_LT((direction_of(face, kFace_px, *ours) - from_lens.normalized()).norm(), 1e-9);
    }
  }
}

TEST(PanoramaFaces, GiveTheirPanoramasPoseBack) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const CameraPose camera = some_pose(seed);
    for (const PanoramaFace& face : cube_faces()) {
      const CameraPose back = camera_pose_of(colmap_pose(camera, face), face);
      EXPECT_LT((back.position_m - camera.position_m).norm(), 1e-14);
      EXPECT_LT((back.world_from_camera - camera.world_from_camera).norm(), 1e-14);
    }
  }
}

// Of every direction exactly one side of the cube sees it (but for edges), by its name.
TEST(PanoramaFaces, OfACubeSeeEveryDirectionOnce) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d direction = random_point(&random, 1.0);
    int seen = 0;
    for (const PanoramaFace& face : cube_faces()) {
      const auto pixel = face_pixel_of(face, kFace_px, direction);
      if (pixel && pixel->x > 0 && pixel->x < kFace_px && pixel->y > 0 && pixel->y < kFace_px) {
        ++seen;
      }
    }
    EXPECT_EQ(seen, 1);
  }
  const std::vector<PanoramaFace> faces = cube_faces();
  EXPECT_GT(faces[1].camera_from_face.col(2).x(), 0.99);   // right
  EXPECT_LT(faces[3].camera_from_face.col(2).x(), -0.99);  // left
  EXPECT_GT(faces[4].camera_from_face.col(2).y(), 0.99);   // up
}

// A panorama whose levels are a function of the direction, for comparison with a face's pixels.
cv::Mat direction_panorama(int width) {
  cv::Mat panorama(width / 2, width, CV_8UC3);
  for (int v = 0; v < panorama.rows; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3d direction = direction_from_angles(
          angles_from_pixel({static_cast<double>(u), static_cast<double>(v)}, {width, width / 2}));
      const double grey =
          128.0 + 60.0 * direction.x() + 40.0 * direction.y() + 20.0 * direction.z();
      panorama.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<uchar>(std::lround(grey)));
    }
  }
  return panorama;
}

TEST(FaceCutter, SamplesThePanoramaInEachDirection) {
  const std::vector<PanoramaFace> faces = cube_faces();
  for (const int width : {256, 2048}) {  // sampled as it is, and reduced before
    const FaceCutter cutter(faces, {width, width / 2}, kFace_px);
    const auto cut = cutter.cut(direction_panorama(width));
    for (std::size_t i = 0; i < faces.size(); ++i) {
      ASSERT_EQ(cut[i].size(), cv::Size(kFace_px, kFace_px));
      ASSERT_EQ(cut[i].type(), CV_8UC3);
      for (int y = 0; y < kFace_px; y += 7) {
        for (int x = 0; x < kFace_px; x += 7) {
          const Eigen::Vector3d direction = direction_of(faces[i], kFace_px, {x + 0.5, y + 0.5});
          EXPECT_NEAR(cut[i].at<cv::Vec3b>(y, x)[1],
                      128.0 + 60.0 * direction.x() + 40.0 * direction.y() + 20.0 * direction.z(),
                      1.6);
        }
      }
    }
  }
}

TEST(FaceCutter, CutsMasksAndMasksSeams) {
  const std::vector<PanoramaFace> faces = cube_faces();
  const FaceCutter cutter(faces, {256, 128}, kFace_px);
  cv::Mat mask(128, 256, CV_8UC1, cv::Scalar(255));
  mask.rowRange(90, 128).setTo(0);  // below -36 degrees
  const auto plain = cutter.cut_mask(mask, 0.0);
  const auto clear = cutter.cut_mask(mask, 5.0);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (int y = 0; y < kFace_px; ++y) {
      for (int x = 0; x < kFace_px; ++x) {
        const Eigen::Vector3d direction = direction_of(faces[i], kFace_px, {x + 0.5, y + 0.5});
        const double below_deg = -degrees_from_radians(std::asin(direction.y()));
        if (std::abs(below_deg - 36.6) < 1.0) continue;  // the mask's own edge
        EXPECT_EQ(plain[i].at<uchar>(y, x) != 0, below_deg < 36.6);
        const double from_seam_deg = degrees_from_radians(std::asin(std::abs(direction.z())));
        EXPECT_EQ(clear[i].at<uchar>(y, x) != 0, below_deg < 36.6 && from_seam_deg > 5.0);
      }
    }
  }
}

}  // namespace
}  // namespace raywalk
