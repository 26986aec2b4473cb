#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/grid.h"
#include "core/view/column_arrays.h"
#include "core/view/precise_positions.h"
#include "core/view/view_plan.h"
#include "tests/bench/error_curves.h"
#include "tests/bench/error_plots.h"

namespace raywalk::bench {
namespace {

// Errors are in pixels of a panorama of this size.
constexpr PanoramaSize kPanorama{4096, 2048};
// Size of the panorama read by the float kernels; large enough that rounding of the weights does
// not matter.
constexpr PanoramaSize kFine{16384, 8192};
constexpr double kPixelsPerRad = kPanorama.width / kTwoPi;
// Number of rows, such that latitudes reach 0.0001 degrees from the pole.
constexpr int kRows = 1 << 20;

// A point at inverse distance omega (1/m) in a row of the column at theta, and the displacement of
// a station.
struct Sighting {
  int row = 0;
  float omega = 0.0f;
  double theta_rad = 0.0;
  Eigen::Vector3d displacement_m{0, 0, 0};  // viewpoint - station
};

template <typename Real>
struct SeenDirection {
  Real turn_rad;  // to the right of the column's own direction
  Real latitude_rad;
};

// The closed form in the arithmetic of Real; the arguments are considered exact.
template <typename Real>
SeenDirection<Real> seen_in(const Sighting& at) {
  using std::atan2, std::cos, std::sin, std::sqrt;
  const Real pi = acos(Real(-1));
  const Real phi = pi / 2 - (Real(at.row) + Real(0.5)) / kRows * pi;
  const Real s = sin(Real(at.theta_rad));
  const Real c = cos(Real(at.theta_rad));
  const Real omega = at.omega;
  const Real x = at.displacement_m.x();
  const Real z = at.displacement_m.z();
  const Real forward = Real(cos(phi)) + omega * (x * s + z * c);
  const Real up = Real(sin(phi)) + omega * Real(at.displacement_m.y());
  const Real side = omega * (x * c - z * s);
  const Real plan = sqrt(Real(forward * forward + side * side));
  return {atan2(side, forward), atan2(up, plan)};
}

template <typename Real>
double pixels_off(const SeenDirection<Real>& found, const SeenDirection<Exact>& exact) {
  auto turn = static_cast<double>(Exact(Exact(found.turn_rad) - exact.turn_rad));
  turn = std::fabs(turn) > kPi ? std::remainder(turn, kTwoPi) : turn;
  const auto latitude = static_cast<double>(Exact(Exact(found.latitude_rad) - exact.latitude_rad));
  const double width = std::cos(static_cast<double>(exact.latitude_rad));
  return kPixelsPerRad * std::hypot(turn * width, latitude);
}

// The position computed by the kernels and by PrecisePositions.
class Positions {
 public:
  Positions() : latitudes_(kRows, kRows), precise_(kRows), arrays_(1) {}

  SeenDirection<double> in_float(const Sighting& at) {
    column_kernels().find_samples(latitudes_.table(at.row), &at.omega, 1,
                                  column_offset(at.displacement_m, at.theta_rad),
                                  {kFine.width, kFine.height, 0, 0.0f}, arrays_.positions());
    const int sample = arrays_.offset_left[0] / 3;
    const int column = sample / kFine.height;
    const double u = column + weight_of(arrays_.weight_right[0]) / 32768.0;
    const double v = sample % kFine.height + weight_of(arrays_.weight_lower[0]) / 32768.0;
    return {std::remainder(u / kFine.width * kTwoPi, kTwoPi),
            kHalfPi - (v + 0.5) / kFine.height * kPi};
  }
  SeenDirection<double> in_double(const Sighting& at) const {
    const PixelPosition seen = precise_.seen_at(
        at.row, at.omega, precise_offset(at.displacement_m, at.theta_rad), kPanorama);
    return {seen.u / kPixelsPerRad, kHalfPi - (seen.v + 0.5) / kPixelsPerRad};
  }
  std::vector<double> errors(const Sighting& at) {
    const SeenDirection<Exact> exact = seen_in<Exact>(at);
    // Beyond the centres of the first and the last row, positions are clamped to that row.
    const double farthest_rad = kHalfPi - 0.5 * kPi / kFine.height;
    SeenDirection<Exact> read = exact;
    read.latitude_rad = std::clamp<Exact>(exact.latitude_rad, -farthest_rad, farthest_rad);
    return {pixels_off(in_float(at), read), pixels_off(in_double(at), exact),
            pixels_off(seen_in<long double>(at), exact)};
  }

 private:
  LatitudeTable latitudes_;
  PrecisePositions precise_;
  PositionArrays arrays_;
};

// Latitudes up to 89.9 degrees; the last plot covers the pole.
int any_row(RandomArguments& random) {
  return static_cast<int>(random.uniform(kRows / 1800.0, kRows * (1.0 - 1.0 / 1800.0)));
}

// A front line's station `step_m` to the right of where the ray crosses, `d_p_m` ahead.
Eigen::Vector3d from_station(double theta_rad, double d_p_m, double step_m) {
  return {-d_p_m * std::sin(theta_rad) - step_m, 0.0, -d_p_m * std::cos(theta_rad)};
}

const std::vector<std::string> kArithmetics{"float (the kernels)", "double", "long double"};

ErrorCurves position_curves(const std::string& title, const std::string& x_label) {
  return {.plot = {.title = title, .x_label = x_label, .y_label = "largest error (px, W = 4096)"},
          .names = kArithmetics};
}

void plot_distance(Positions* positions, const std::filesystem::path& file) {
  ErrorCurves curves = position_curves("Sample position, line 0.5 m ahead",
                                       "distance of the point from the viewpoint (m)");
  curves.plot.references = {{0.5, "at the station"}};
  curves.most = 1e8;
  curves.errors = [positions](double distance_m, RandomArguments& random) {
    const double theta_rad = random.uniform(-0.7, 0.7);
    return positions->errors({any_row(random), static_cast<float>(1.0 / distance_m), theta_rad,
                              from_station(theta_rad, 0.5, random.uniform(-0.0125, 0.0125))});
  };
  write_error_curves(std::move(curves), file);
}

void plot_step(Positions* positions, const std::filesystem::path& file) {
  ErrorCurves curves = position_curves("Sample position, points 0.3 to 12 m away",
                                       "distance of the station from the viewpoint (m)");
  curves.most = 10.0;
  curves.errors = [positions](double step_m, RandomArguments& random) {
    const double theta_rad = random.uniform(-0.7, 0.7);
    return positions->errors({any_row(random),
                              static_cast<float>(1.0 / random.log_uniform(0.3, 12.0)), theta_rad,
                              from_station(theta_rad, 0.0, step_m)});
  };
  write_error_curves(std::move(curves), file);
}

void plot_pole(Positions* positions, const std::filesystem::path& file) {
  ErrorCurves curves = position_curves("Sample position, points 0.3 to 12 m away, line 0.5 m ahead",
                                       "90 degrees - phi (degrees)");
  curves.least = 1e-4;
  curves.most = 90.0;
  curves.errors = [positions](double from_pole_deg, RandomArguments& random) {
    const double theta_rad = random.uniform(-0.7, 0.7);
    const int row = static_cast<int>(from_pole_deg / 180.0 * kRows);
    return positions->errors({row, static_cast<float>(1.0 / random.log_uniform(0.3, 12.0)),
                              theta_rad,
                              from_station(theta_rad, 0.5, random.uniform(-0.0125, 0.0125))});
  };
  write_error_curves(std::move(curves), file);
}

void plot_near(Positions* positions, const std::filesystem::path& file) {
  ErrorCurves curves = position_curves("Sample position, points 0.5 m from the viewpoint",
                                       "distance of the point from the station (m)");
  curves.errors = [positions](double near_m, RandomArguments& random) {
    const int row = any_row(random);
    const double theta_rad = random.uniform(-kPi, kPi);
    const double phi_rad = kHalfPi - (row + 0.5) / kRows * kPi;
    const Eigen::Vector3d away =
        direction_from_angles({random.uniform(-kPi, kPi), std::asin(random.uniform(-1.0, 1.0))});
    return positions->errors(
        {row, 2.0f, theta_rad,
         -(0.5 * direction_from_angles({theta_rad, phi_rad}) + near_m * away)});
  };
  write_error_curves(std::move(curves), file);
}

// Position at which a ray crosses a line `b_m` ahead, to the right of the viewpoint.
template <typename Real>
Real crossing_in(double b_m, double theta_rad) {
  using std::cos, std::sin;
  return Real(b_m) * Real(sin(Real(theta_rad))) / Real(cos(Real(theta_rad)));
}

// Error of the crossing point, which selects and weights the stations, in metres along the line.
void plot_incidence(const std::filesystem::path& file) {
  ErrorCurves curves{.plot = {.title = "Where a ray crosses a line 1 um to 0.5 m ahead",
                              .x_label = "90 degrees - incidence (degrees)",
                              .y_label = "largest error along the line (m)",
                              .references = {{180.0 / kPanorama.width, "last column, W = 4096"}}},
                     .names = {"float", "double (the plan)", "long double"},
                     .least = 1e-4,
                     .most = 45.0};
  curves.errors = [](double from_line_deg, RandomArguments& random) -> std::vector<double> {
    const double theta_rad = kHalfPi - radians_from_degrees(from_line_deg);
    const double b_m = random.log_uniform(1e-6, 0.5);
    Line line;
    line.origin = {0.0, b_m};
    line.direction = {1.0, 0.0};
    const auto found = cross_line(line, {0.0, 0.0}, theta_rad);
    const Exact exact = crossing_in<Exact>(b_m, theta_rad);
    const auto off = [&](const Exact& value) {
      return std::fabs(static_cast<double>(Exact(value - exact)));
    };
    return {off(crossing_in<float>(b_m, theta_rad)),
            found ? off(found->along_m) : std::numeric_limits<double>::infinity(),
            off(crossing_in<long double>(b_m, theta_rad))};
  };
  write_error_curves(std::move(curves), file);
}

}  // namespace

void write_position_error_plots(const std::filesystem::path& directory) {
  Positions positions;
  plot_distance(&positions, directory / "position-distance.svg");
  plot_step(&positions, directory / "position-station.svg");
  plot_pole(&positions, directory / "position-pole.svg");
  plot_near(&positions, directory / "position-near.svg");
  plot_incidence(directory / "position-incidence.svg");
}

}  // namespace raywalk::bench
