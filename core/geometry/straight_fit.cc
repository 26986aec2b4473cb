#include "core/geometry/straight_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raywalk {
namespace {

Strip strip_of_slope(std::span<const Eigen::Vector2d> points, double slope) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector2d& point : points) {
    const double v = point.y() - slope * point.x();
    low = std::min(low, v);
    high = std::max(high, v);
  }
  return {slope, 0.5 * (low + high), 0.5 * (high - low)};
}

}  // namespace

StraightFit::StraightFit(std::span<const Eigen::Vector2d> points)
    : count_(static_cast<double>(points.size())) {
  for (const Eigen::Vector2d& point : points) {
    middle_u += point.x() / count_;
    middle_v += point.y() / count_;
  }
  double products = 0.0;
  for (const Eigen::Vector2d& point : points) {
    const double u = point.x() - middle_u;
    scatter_u_ += u * u;
    products += u * (point.y() - middle_v);
  }
  if (scatter_u_ > 0.0) slope = products / scatter_u_;
  if (points.size() < 3) return;
  for (const Eigen::Vector2d& point : points) variance_ += off(point) * off(point) / (count_ - 2.0);
}

double StraightFit::error_at(double u) const {
  if (scatter_u_ <= 0.0) return 0.0;
  const double from_middle = u - middle_u;
  return std::sqrt(variance_ * (1.0 / count_ + from_middle * from_middle / scatter_u_));
}

// The width is a convex function of the slope: a maximum minus a minimum of linear ones.
Strip narrowest_strip(std::span<const Eigen::Vector2d> points, double steepest) {
  constexpr int kThirds = 80;  // (2/3)^80 < 1e-14
  double low = -steepest, high = steepest;
  for (int i = 0; i < kThirds; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    if (strip_of_slope(points, a).half_width <= strip_of_slope(points, b).half_width) {
      high = b;
    } else {
      low = a;
    }
  }
  return strip_of_slope(points, 0.5 * (low + high));
}

}  // namespace raywalk
