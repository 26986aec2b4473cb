#include "calibrate/lens/image_circle.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/median.h"

namespace raywalk::calibrate {
namespace {

constexpr int kAzimuths = 360;
// The rim is where the level falls below this share of that further in.
constexpr double kDarkShare = 0.2;
constexpr double kLeastLight = 12.0;  // levels; a scene darker than this shows no rim
// Shares of the start's radius: what is certainly inside, and the limit of the search.
constexpr double kInside = 0.75;
constexpr double kOutside = 1.25;

// The first dark pixel outwards; nullopt if the picture ends before.
std::optional<PixelPosition> rim_along(const cv::Mat& brightest, const DualFisheyeCamera& start,
                                       bool back, double azimuth_rad) {
  const FisheyeLens& lens = back ? start.layout.back : start.layout.front;
  const double expected_px = rim_radius_px(lens);
  const auto at = [&](double radius_px) {
    return PixelPosition{lens.centre.u + radius_px * std::cos(azimuth_rad),
                         lens.centre.v + radius_px * std::sin(azimuth_rad)};
  };
  const auto level = [&](PixelPosition pixel) -> std::optional<double> {
    const int u = static_cast<int>(std::lround(pixel.u)),
              v = static_cast<int>(std::lround(pixel.v));
    if (u < 0 || v < 0 || u >= brightest.cols || v >= brightest.rows) return std::nullopt;
    if (!start.two_files && belongs_to_back(start.layout, pixel) != back) return std::nullopt;
    return brightest.at<uchar>(v, u);
  };
  std::vector<double> inside;
  for (double share = 0.5 * kInside; share < kInside; share += 0.02) {
    if (const auto light = level(at(share * expected_px))) inside.push_back(*light);
  }
  if (inside.empty()) return std::nullopt;
  const double light = median(std::move(inside));
  if (light < kLeastLight) return std::nullopt;
  for (double radius_px = kInside * expected_px; radius_px < kOutside * expected_px;
       radius_px += 0.25) {
    const auto here = level(at(radius_px)), further = level(at(radius_px + 2.0));
    if (!here || !further) return std::nullopt;
    if (std::max(*here, *further) < kDarkShare * light) return at(radius_px);
  }
  return std::nullopt;
}

// u^2 + v^2 = 2 cu u + 2 cv v + (r^2 - cu^2 - cv^2) is linear in its three unknowns (Kasa 1976).
ImageCircle circle_through(const std::vector<PixelPosition>& points) {
  Eigen::MatrixX3d left(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::VectorXd right(left.rows());
  for (Eigen::Index i = 0; i < left.rows(); ++i) {
    const PixelPosition& point = points[static_cast<std::size_t>(i)];
    left.row(i) << 2.0 * point.u, 2.0 * point.v, 1.0;
    right[i] = point.u * point.u + point.v * point.v;
  }
  const Eigen::Vector3d solution = left.colPivHouseholderQr().solve(right);
  return {{solution[0], solution[1]},
          std::sqrt(std::max(0.0, solution[2] + solution.head<2>().squaredNorm()))};
}

double off_circle_px(const ImageCircle& circle, PixelPosition point) {
  return std::fabs(distance_px(point, circle.centre) - circle.radius_px);
}

}  // namespace

double distance_px(PixelPosition a, PixelPosition b) { return std::hypot(a.u - b.u, a.v - b.v); }

bool belongs_to_back(const DualFisheyeLayout& layout, PixelPosition pixel) {
  return distance_px(pixel, layout.back.centre) < distance_px(pixel, layout.front.centre);
}

std::optional<ImageCircle> find_image_circle(const cv::Mat& brightest,
                                             const DualFisheyeCamera& start, bool back) {
  std::vector<PixelPosition> points;
  for (int i = 0; i < kAzimuths; ++i) {
    if (const auto rim = rim_along(brightest, start, back, kTwoPi * i / kAzimuths)) {
      points.push_back(*rim);
    }
  }
  constexpr double kLargestScatter_px = 1.5;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    if (2 * static_cast<int>(points.size()) < kAzimuths) return std::nullopt;
    const ImageCircle circle = circle_through(points);
    std::vector<double> off_px;
    off_px.reserve(points.size());
    for (const PixelPosition& point : points) off_px.push_back(off_circle_px(circle, point));
    const double middle_px = median(off_px);
    if (round + 1 == kRounds) {
      return middle_px <= kLargestScatter_px ? std::optional(circle) : std::nullopt;
    }
    // Dark objects at the rim look like its end: points far from the circle are outliers.
    const double most_px = std::max(1.0, 3.0 * middle_px);
    std::erase_if(points,
                  [&](PixelPosition point) { return off_circle_px(circle, point) > most_px; });
  }
  return std::nullopt;
}

double rim_radius_px(const FisheyeLens& lens) {
  return lens.focal_px * fisheye_radius(lens.k, lens.largest_angle_rad);
}

FisheyeLens with_rim_at(FisheyeLens lens, double radius_px) {
  constexpr double kStep_rad = 1e-4;
  constexpr double kWidest_rad = radians_from_degrees(130.0);
  const auto radius_at = [&](double t) { return lens.focal_px * fisheye_radius(lens.k, t); };
  for (double t = kStep_rad; t < kWidest_rad; t += kStep_rad) {
    if (radius_at(t + kStep_rad) <= radius_at(t)) break;
    lens.largest_angle_rad = t;
    if (radius_at(t) >= radius_px) break;
  }
  return lens;
}

}  // namespace raywalk::calibrate
