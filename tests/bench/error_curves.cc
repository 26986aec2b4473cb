#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "core/files/atomic_output.h"
#include "core/geometry/error_model.h"
#include "core/geometry/sphere.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

// Reference arithmetic with 50 digits.
using Exact = boost::multiprecision::cpp_bin_float_50;

// Random numbers that are the same on every platform, unlike the distributions of <random>.
class RandomArguments {
 public:
  double uniform(double least, double most) {
    return least + static_cast<double>(random_() >> 11) * 0x1p-53 * (most - least);
  }
  double log_uniform(double least, double most) {
    return std::exp(uniform(std::log(least), std::log(most)));
  }

 private:
  std::mt19937_64 random_;
};

constexpr int kForms = 4;
// The error of each form for one random case near an argument.
using Errors = std::array<double, kForms>;
using ErrorsNear = std::function<Errors(double argument, RandomArguments& random)>;

constexpr double kNoError = 1e-20;
constexpr double kLeastArgument = 1e-6;
constexpr int kPerDecade = 8;
constexpr int kCasesPerPoint = 150;

// Writes a table of the arguments and the largest error of every form that is found near each. An
// error of exactly 0 counts as `kNoError`, below the resolution of long double.
void write_error_curves(double most, const ErrorsNear& errors_near,
                        const std::filesystem::path& file) {
  RandomArguments random;
  std::string table =
      "argument,printed float,printed double,printed long double,closed form in double";
  const double decades = std::log10(most / kLeastArgument);
  const int points = static_cast<int>(std::lround(decades * kPerDecade));
  const double step = std::pow(most / kLeastArgument, 1.0 / points);
  for (int i = 0; i < points; ++i) {
    const double low = kLeastArgument * std::pow(step, i);
    Errors worst;
    worst.fill(kNoError);
    for (int n = 0; n < kCasesPerPoint; ++n) {
      const Errors errors = errors_near(random.log_uniform(low, low * step), random);
      for (size_t c = 0; c < worst.size(); ++c) worst[c] = std::max(worst[c], errors[c]);
    }
    table += fmt::format("\n{:.6g}", low * std::sqrt(step));
    for (const double error : worst) table += fmt::format(",{:.4g}", error);
  }
  write_file_atomically(file, table + "\n");
}

// (2) and (4) as the paper prints them.
template <typename Real>
Real printed_shift(double d_src_m, double phi_rad, double apart_m) {
  using std::atan2, std::cos, std::sin;
  const Real phi = phi_rad;
  const Real up = Real(d_src_m) * Real(sin(phi));
  const Real ahead = Real(d_src_m) * Real(cos(phi));
  return Real(atan2(up, ahead)) - Real(atan2(up, Real(ahead + Real(apart_m))));
}

// (3) as the paper prints it.
template <typename Real>
Real printed_bending(double d_src_m, double phi_rad, double theta_rad, double step_m) {
  using std::cos, std::sin, std::sqrt;
  const Real c = Real(d_src_m) * Real(cos(Real(phi_rad)));
  const Real theta = theta_rad;
  const Real ahead = c * Real(cos(theta));
  const Real aside = c * Real(sin(theta)) + Real(step_m);
  return Real(sqrt(Real(ahead * ahead + aside * aside))) - c;
}

double relative_error(const Exact& value, const Exact& exact) {
  return std::fabs(static_cast<double>(Exact((value - exact) / exact)));
}

Errors shift_errors(double d_src_m, double phi_rad, double apart_m) {
  const Exact exact = printed_shift<Exact>(d_src_m, phi_rad, apart_m);
  return {relative_error(printed_shift<float>(d_src_m, phi_rad, apart_m), exact),
          relative_error(printed_shift<double>(d_src_m, phi_rad, apart_m), exact),
          relative_error(printed_shift<long double>(d_src_m, phi_rad, apart_m), exact),
          relative_error(latitude_shift(d_src_m, phi_rad, apart_m), exact)};
}

Errors bending_errors(double d_src_m, double phi_rad, double theta_rad, double step_m) {
  const Exact exact = printed_bending<Exact>(d_src_m, phi_rad, theta_rad, step_m);
  return {relative_error(printed_bending<float>(d_src_m, phi_rad, theta_rad, step_m), exact),
          relative_error(printed_bending<double>(d_src_m, phi_rad, theta_rad, step_m), exact),
          relative_error(printed_bending<long double>(d_src_m, phi_rad, theta_rad, step_m), exact),
          relative_error(bending_distance(d_src_m, phi_rad, theta_rad, step_m), exact)};
}

}  // namespace

void write_model_errors(const std::filesystem::path& directory) {
  // (4) with 0.1 m between acquisition points, over the distance of the source in m.
  const ErrorsNear distance = [](double d_src_m, RandomArguments& random) {
    return shift_errors(d_src_m, random.uniform(0.2, 1.4), 0.1);
  };
  write_error_curves(1e8, distance, directory / "model-distance.csv");

  // (3) at 1 to 10 m, over the step between stations in m.
  const ErrorsNear step = [](double step_m, RandomArguments& random) {
    return bending_errors(random.log_uniform(1.0, 10.0), random.uniform(-1.4, 1.4),
                          random.uniform(0.2, 1.4), step_m);
  };
  write_error_curves(10.0, step, directory / "model-step.csv");

  // (4) at 1 to 10 m with 0.1 m between acquisition points, over the latitude in degrees.
  const ErrorsNear latitude = [](double phi_deg, RandomArguments& random) {
    return shift_errors(random.log_uniform(1.0, 10.0), radians_from_degrees(phi_deg), 0.1);
  };
  write_error_curves(90.0, latitude, directory / "model-phi.csv");
}

}  // namespace raywalk::bench
