#include "calibrate/poses/matching_faces.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr std::array<double, kFaceCount> kFaceYaw_deg{45.0, 135.0, -135.0, -45.0};
constexpr int kSmallestFace_px = 384;
constexpr int kLargestFace_px = 768;

}  // namespace

std::array<PanoramaFace, kFaceCount> panorama_faces(
    const std::optional<DualFisheyeLayout>& lenses) {
  std::array<PanoramaFace, kFaceCount> faces{};
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

}  // namespace raywalk::calibrate
