#include "simulator/room/camera_ring.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/hash_random.h"

namespace raywalk::capture {
namespace {

double longitude_of(const RingSettings& ring, int camera) { return kTwoPi * camera / ring.cameras; }

double spread_gain(double spread, HashRandom random) {
  return std::clamp(1.0 + spread * random.normal(), 0.25, 4.0);
}

double theta_at(double column, PanoramaSize size) {
  return angles_from_pixel({column, 0.0}, size).theta_rad;
}

int camera_at(const RingCameras& at, RingRays::Camera camera) {
  return camera == RingRays::Camera::kOwn ? at.own : at.other;
}

}  // namespace

RingCameras ring_cameras(const RingSettings& ring, double theta_rad) {
  const double sector = kTwoPi / ring.cameras;
  const auto number = static_cast<int>(std::lround(theta_rad / sector));
  const double off_axis = theta_rad - number * sector;
  const auto camera = [&](int i) { return (i % ring.cameras + ring.cameras) % ring.cameras; };
  RingCameras at{camera(number), camera(number + (off_axis < 0.0 ? -1 : 1)), 0.0};
  const double to_seam = std::max(0.5 * sector - std::abs(off_axis), 0.0);
  const double half_feather = 0.5 * radians_from_degrees(ring.feather_deg);
  if (to_seam < half_feather) at.other_weight = 0.5 * (1.0 - to_seam / half_feather);
  return at;
}

RingRays::RingRays(const RingSettings& ring, PanoramaSize size, Camera camera) : panorama_(size) {
  for (int part = 0; part < size.width * kPixelParts; ++part) {
    const RingCameras at = ring_cameras(ring, theta_at(position_of_part(part), size));
    const double theta = longitude_of(ring, camera_at(at, camera));
    if (camera == Camera::kOther && at.other_weight == 0.0) {
      origins_m_.emplace_back();
    } else {
      origins_m_.emplace_back(1e-3 * ring.radius_mm * direction_from_angles({theta, 0.0}));
    }
  }
}

std::optional<CameraRay> RingRays::at_part(int part_u, int part_v) const {
  const auto& origin_m = origins_m_[static_cast<std::size_t>(part_u)];
  if (!origin_m) return std::nullopt;
  std::optional<CameraRay> ray = panorama_.at_part(part_u, part_v);
  ray->origin_m = *origin_m;
  return ray;
}

std::vector<double> ring_gains(const RingSettings& ring, int seed, int moment) {
  const HashRandom all(hash_bits(static_cast<std::uint64_t>(seed), 0x419));
  std::vector<double> gains;
  for (int camera = 0; camera < ring.cameras; ++camera) {
    const HashRandom own = all.branch(static_cast<std::uint64_t>(camera));
    gains.push_back(
        spread_gain(ring.gain_spread, own) *
        spread_gain(ring.station_gain_spread, own.branch(static_cast<std::uint64_t>(moment))));
  }
  return gains;
}

cv::Mat ring_light(const RingSettings& ring, const std::vector<double>& gains, PanoramaSize size,
                   RingRays::Camera camera) {
  cv::Mat light(size.height, size.width, CV_32FC1);
  for (int u = 0; u < size.width; ++u) {
    const double theta = theta_at(u, size);
    const int seen_by = camera_at(ring_cameras(ring, theta), camera);
    const double gain = gains[static_cast<std::size_t>(seen_by)];
    const double off_axis = std::cos(theta - longitude_of(ring, seen_by));
    for (int v = 0; v < size.height; ++v) {
      const double phi = angles_from_pixel({0.0, static_cast<double>(v)}, size).phi_rad;
      const double angle = std::acos(std::clamp(std::cos(phi) * off_axis, -1.0, 1.0));
      const double lost = ring.vignetting_share * (angle / kHalfPi) * (angle / kHalfPi);
      light.at<float>(v, u) = static_cast<float>(gain * std::max(1.0 - lost, 0.0));
    }
  }
  return light;
}

cv::Mat stitched(const RingSettings& ring, const cv::Mat& own, const cv::Mat& other) {
  const PanoramaSize size{own.cols, own.rows};
  cv::Mat panorama = own.clone();
  for (int u = 0; u < size.width; ++u) {
    const double weight = ring_cameras(ring, theta_at(u, size)).other_weight;
    if (weight == 0.0) continue;
    for (int v = 0; v < size.height; ++v) {
      const cv::Vec3d blend = (1.0 - weight) * cv::Vec3d(own.at<cv::Vec3b>(v, u)) +
                              weight * cv::Vec3d(other.at<cv::Vec3b>(v, u));
      panorama.at<cv::Vec3b>(v, u) = cv::Vec3b(blend);
    }
  }
  return panorama;
}

}  // namespace raywalk::capture
