#include "calibrate/poses/matching_faces.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr std::array<double, kFaceCount> kFaceYaw_deg{45.0, 135.0, -135.0, -45.0};
constexpr int kSmallestFace_px = 384;
constexpr int kLargestFace_px = 768;

}  // namespace

MatchingFaces panorama_faces(const std::optional<DualFisheyeLayout>& lenses) {
  MatchingFaces faces{};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double yaw_rad = radians_from_degrees(kFaceYaw_deg[i]);
    faces[i].camera_from_face = world_from_camera({yaw_rad, 0.0, 0.0});
    const bool front = std::abs(yaw_rad) < kHalfPi;
    if (lenses) faces[i].centre_m = front ? lenses->front_position_m : lenses->back_position_m;
  }
  return faces;
}

int default_face_px(int panorama_width) {
  return std::clamp(panorama_width / 2, kSmallestFace_px, kLargestFace_px);
}

std::vector<FacePair> overlapping_faces(const MatchingFaces& faces,
                                        const Eigen::Matrix3d& world_from_first,
                                        const Eigen::Matrix3d& world_from_second) {
  static const double kSame = std::cos(radians_from_degrees(20.0));
  static const double kOverlapping = std::cos(radians_from_degrees(60.0));
  std::vector<FacePair> pairs;
  for (std::size_t first = 0; first < kFaceCount; ++first) {
    const Eigen::Vector3d axis = world_from_first * faces[first].camera_from_face.col(2);
    std::array<double, kFaceCount> cosines{};
    for (std::size_t second = 0; second < kFaceCount; ++second) {
      cosines[second] = axis.dot(world_from_second * faces[second].camera_from_face.col(2));
    }
    const double best = *std::max_element(cosines.begin(), cosines.end());
    for (std::size_t second = 0; second < kFaceCount; ++second) {
      if (cosines[second] == best || (best < kSame && cosines[second] > kOverlapping)) {
        pairs.push_back({first, second});
      }
    }
  }
  return pairs;
}

}  // namespace raywalk::calibrate
