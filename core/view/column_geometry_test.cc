// Where the points of a view lie in stations, against double arithmetic.
#include "core/view/column_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace raywalk {
namespace {

using Eigen::Vector3d;

class RandomPoints {
 public:
  double uniform(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  double log_uniform(double least, double most) {
    return std::exp(uniform(std::log(least), std::log(most)));
  }
  Vector3d place(double reach_m) {
    return {uniform(-reach_m, reach_m), uniform(-reach_m, reach_m), uniform(-reach_m, reach_m)};
  }

 private:
  std::mt19937_64 random_{17};
};

// From 1 nm to 1,000,000 km and infinitely far, from stations micrometres and kilometres away.
TEST(ColumnGeometryProperty, PointsLieInStationsWhereDoubleArithmeticSaysTheyDo) {
  RandomPoints random;
  for (int i = 0; i < 200000; ++i) {
    const double inverse = i % 50 == 0 ? 0.0 : random.log_uniform(1e-9, 1e9);
    const Vector3d eye_m = random.place(random.log_uniform(1e-6, 1e3));
    const Vector3d station_m =
        i % 30 == 0 ? eye_m : eye_m + random.place(random.log_uniform(1e-6, 1e3));
    const SphereAngles at{random.uniform(-kPi, kPi), random.uniform(-kHalfPi, kHalfPi)};
    const auto sin_phi = static_cast<float>(std::sin(at.phi_rad));
    const auto cos_phi = static_cast<float>(std::cos(at.phi_rad));
    const SeenPoint seen = seen_from(sin_phi, cos_phi, static_cast<float>(inverse),
                                     offset_in_column(eye_m - station_m, at.theta_rad));

    const Vector3d r = direction_from_angles(at) + inverse * (eye_m - station_m);
    const SphereAngles truth = angles_from_direction(r);
    // What one step of a float of the largest summand turns the direction by: a station right
    // beside the point sees it in any direction.
    const double step = std::ldexp(1.0, -23) * (1.0 + inverse * (eye_m - station_m).norm());
    const double exact_rad = 1.5e-6 + 4.0 * step / r.norm();
    if (exact_rad > 0.1) continue;
    ASSERT_NEAR(seen.phi_rad, truth.phi_rad, exact_rad) << inverse << " 1/m";
    const double turned = wrap_angle(at.theta_rad + seen.turn_rad - truth.theta_rad);
    ASSERT_LE(std::fabs(turned) * std::hypot(r.x(), r.z()), exact_rad * r.norm())
        << inverse << " 1/m";
    ASSERT_NEAR(seen.length, r.norm(), 1e-6 * r.norm() + 4.0 * step);
  }
}

}  // namespace
}  // namespace raywalk
