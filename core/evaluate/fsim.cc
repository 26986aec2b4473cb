#include "core/evaluate/fsim.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/evaluate/metrics.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr int kMinSide_px = 8;
constexpr double kWorkingSide_px = 256.0;
constexpr double kT1 = 0.85;   // for phase congruency, which is within [0, 1]
constexpr double kT2 = 160.0;  // for gradients in 8-bit levels per pixel

// The panorama with `border` pixels around it: columns wrap, the top and bottom row repeat.
cv::Mat with_border(const cv::Mat& image, int border) {
  cv::Mat wide;
  cv::copyMakeBorder(image, wide, 0, 0, border, border, cv::BORDER_WRAP);
  cv::Mat framed;
  cv::copyMakeBorder(wide, framed, border, border, 0, 0, cv::BORDER_REPLICATE);
  return framed;
}

// CV_64FC1, BT.601 over the full range, not rounded.
cv::Mat luma_of(const cv::Mat& bgr) {
  cv::Mat samples, luma;
  bgr.convertTo(samples, CV_64F);
  // cvtColor does not take double.
  cv::transform(samples, luma, cv::Matx13d(0.114, 0.587, 0.299));
  return luma;
}

// Means of factor x factor pixels around every factor-th pixel, from the first on. For an even
// factor the window cannot be centred; it reaches one pixel further to the right and down, so that
// a factor of 2 averages disjoint squares.
cv::Mat reduced(const cv::Mat& image, int factor) {
  if (factor == 1) return image;
  const int before = (factor - 1) / 2;
  cv::Mat means;
  cv::boxFilter(with_border(image, factor), means, CV_64F, cv::Size(factor, factor),
                cv::Point(before, before));
  cv::Mat out((image.rows + factor - 1) / factor, (image.cols + factor - 1) / factor, CV_64FC1);
  for (int row = 0; row < out.rows; ++row) {
    for (int col = 0; col < out.cols; ++col) {
      out.at<double>(row, col) = means.at<double>((row + 1) * factor, (col + 1) * factor);
    }
  }
  return out;
}

// Magnitude of the Scharr gradient, in levels per two pixels as the paper's kernels (weights 3, 10,
// 3 over 16) give it.
cv::Mat gradient_magnitude(const cv::Mat& image) {
  const cv::Mat framed = with_border(image, 1);
  const cv::Rect inside(1, 1, image.cols, image.rows);
  cv::Mat along_x;
  cv::Mat along_y;
  cv::Scharr(framed, along_x, CV_64F, 1, 0, 1.0 / 16.0);
  cv::Scharr(framed, along_y, CV_64F, 0, 1, 1.0 / 16.0);
  cv::Mat magnitude;
  cv::magnitude(along_x(inside), along_y(inside), magnitude);
  return magnitude;
}

double similarity(double a, double b, double constant) {
  return (2.0 * a * b + constant) / (a * a + b * b + constant);
}

double pooled_similarity(const cv::Mat& congruency_a, const cv::Mat& congruency_b,
                         const cv::Mat& gradient_a, const cv::Mat& gradient_b) {
  double sum = 0.0;
  double weight_sum = 0.0;
  for (int row = 0; row < congruency_a.rows; ++row) {
    for (int col = 0; col < congruency_a.cols; ++col) {
      const double pa = congruency_a.at<double>(row, col);
      const double pb = congruency_b.at<double>(row, col);
      const double gradients =
          similarity(gradient_a.at<double>(row, col), gradient_b.at<double>(row, col), kT2);
      const double weight = std::max(pa, pb);
      sum += similarity(pa, pb, kT1) * gradients * weight;
      weight_sum += weight;
    }
  }
  return weight_sum > 0.0 ? sum / weight_sum : 1.0;
}

// Parameters of Zhang et al. 2011.
constexpr double kShortestWavelength_px = 6.0;
constexpr double kScaleFactor = 2.0;
constexpr double kBandwidth = 0.55;         // sigma_r over the centre frequency
constexpr double kSpacingOverSpread = 1.2;  // orientation spacing over sigma_theta
constexpr double kNoiseDeviations = 2.0;    // k: standard deviations above the mean of noise
constexpr double kEpsilon = 1e-4;           // against 0/0, in 8-bit levels
// The threshold is derived for |sum of responses|; the measure used takes |sin| off that and so is
// smaller on noise. Kovesi found this factor by trial, and FSIM's published values were made with
// it.
constexpr double kNoiseOverestimate = 1.7;
// Filters reach beyond the Nyquist frequency in the corners of the spectrum only; a Butterworth
// low-pass makes all orientations cover the same disc.
constexpr double kCutoff = 0.45;  // cycles per pixel
constexpr double kCutoffOrder = 15.0;

using Complex = cv::Vec2d;

// Frequency of bin `index` of a Fourier transform over n samples, in cycles per pixel, [-0.5, 0.5).
double bin_frequency(int index, int n) {
  return static_cast<double>(2 * index < n ? index : index - n) / n;
}

// Calls f(x, y) with the frequency of every bin and collects what it returns.
template <typename Function>
cv::Mat over_frequencies(cv::Size size, Function f) {
  cv::Mat values(size, CV_64FC1);
  for (int row = 0; row < size.height; ++row) {
    const double y = bin_frequency(row, size.height);
    auto* out = values.ptr<double>(row);
    for (int col = 0; col < size.width; ++col) out[col] = f(bin_frequency(col, size.width), y);
  }
  return values;
}

// exp(-ln(r / f0)^2 / (2 ln(sigma_r / f0)^2)), a Gaussian in log frequency: no response at all to
// the mean of the image.
cv::Mat log_gabor(cv::Size size, double centre_frequency) {
  const double log_bandwidth = std::log(kBandwidth);
  return over_frequencies(size, [=](double x, double y) {
    const double radius = std::hypot(x, y);
    if (radius == 0.0) return 0.0;
    const double offset = std::log(radius / centre_frequency) / log_bandwidth;
    const double low_pass = 1.0 / (1.0 + std::pow(radius / kCutoff, 2.0 * kCutoffOrder));
    return std::exp(-0.5 * offset * offset) * low_pass;
  });
}

// A Gaussian around one direction and not its opposite: the response is analytic, its real part
// even-symmetric (lines), its imaginary part odd-symmetric (steps).
cv::Mat angular_window(cv::Size size, double direction_rad, double sigma_rad) {
  return over_frequencies(size, [=](double x, double y) {
    const double offset = wrap_angle(std::atan2(y, x) - direction_rad) / sigma_rad;
    return std::exp(-0.5 * offset * offset);
  });
}

// Fourier transform without the mean, which no filter passes and which would only leave rounding
// errors on flat images.
cv::Mat spectrum_of(const cv::Mat& grey) {
  cv::Mat spectrum;
  cv::dft(grey - cv::mean(grey), spectrum, cv::DFT_COMPLEX_OUTPUT);
  return spectrum;
}

cv::Mat filtered(const cv::Mat& spectrum, const cv::Mat& radial, const cv::Mat& angular) {
  cv::Mat product(spectrum.size(), CV_64FC2);
  for (int row = 0; row < spectrum.rows; ++row) {
    const auto* in = spectrum.ptr<Complex>(row);
    const auto* r = radial.ptr<double>(row);
    const auto* a = angular.ptr<double>(row);
    auto* out = product.ptr<Complex>(row);
    for (int col = 0; col < spectrum.cols; ++col) out[col] = in[col] * (r[col] * a[col]);
  }
  cv::idft(product, product, cv::DFT_SCALE);
  return product;
}

double median_squared_magnitude(const cv::Mat& response) {
  std::vector<double> squares;
  squares.reserve(response.total());
  for (int row = 0; row < response.rows; ++row) {
    const auto* in = response.ptr<Complex>(row);
    for (int col = 0; col < response.cols; ++col) squares.push_back(in[col].dot(in[col]));
  }
  return median(std::move(squares));
}

}  // namespace

double fsim(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kMinSide_px);
  const int factor =
      std::max(1, static_cast<int>(std::lround(std::min(a.rows, a.cols) / kWorkingSide_px)));
  const cv::Mat luma_a = reduced(luma_of(a), factor);
  const cv::Mat luma_b = reduced(luma_of(b), factor);
  const PhaseCongruency congruency(luma_a.size());
  return pooled_similarity(congruency(luma_a), congruency(luma_b), gradient_magnitude(luma_a),
                           gradient_magnitude(luma_b));
}

PhaseCongruency::PhaseCongruency(cv::Size size) : size_(size) {
  double wavelength_px = kShortestWavelength_px;
  for (cv::Mat& filter : radial_) {
    filter = log_gabor(size, 1.0 / wavelength_px);
    wavelength_px *= kScaleFactor;
  }
  const double spacing_rad = kPi / kOrientations;
  for (int i = 0; i < kOrientations; ++i) {
    angular_[i] = angular_window(size, i * spacing_rad, spacing_rad / kSpacingOverSpread);
  }
}

// PC = sum over orientations of energy / (epsilon + sum over orientations and scales of amplitude).
cv::Mat PhaseCongruency::operator()(const cv::Mat& grey) const {
  const cv::Mat spectrum = spectrum_of(grey);
  cv::Mat energy = cv::Mat::zeros(size_, CV_64FC1);
  cv::Mat amplitude(size_, CV_64FC1, cv::Scalar::all(kEpsilon));
  for (int orientation = 0; orientation < kOrientations; ++orientation) {
    add_orientation(spectrum, orientation, &energy, &amplitude);
  }
  return energy / amplitude;
}

// With the responses R_n of the scales as complex numbers, A_n = |R_n| and the unit vector u along
// their sum, the mean phase: a scale that is off the mean phase by delta_n contributes
//   A_n (cos delta_n - |sin delta_n|) = R_n . u - |R_n x u|,
// which falls off linearly around agreement, where the cosine alone would not (Kovesi's sharper
// measure). The noise threshold is subtracted from the sum; negative results count as 0.
void PhaseCongruency::add_orientation(const cv::Mat& spectrum, int orientation, cv::Mat* energy,
                                      cv::Mat* amplitude) const {
  std::array<cv::Mat, kScales> responses;
  for (int scale = 0; scale < kScales; ++scale) {
    responses[scale] = filtered(spectrum, radial_[scale], angular_[orientation]);
  }
  const double threshold = noise_threshold(responses.front(), orientation);
  for (int row = 0; row < size_.height; ++row) {
    auto* energy_row = energy->ptr<double>(row);
    auto* amplitude_row = amplitude->ptr<double>(row);
    for (int col = 0; col < size_.width; ++col) {
      Complex sum(0.0, 0.0);
      for (const cv::Mat& response : responses) sum += response.at<Complex>(row, col);
      const Complex mean_phase = sum * (1.0 / (std::sqrt(sum.dot(sum)) + kEpsilon));
      double agreement = 0.0;
      for (const cv::Mat& response : responses) {
        const Complex r = response.at<Complex>(row, col);
        agreement += r.dot(mean_phase) - std::abs(r[0] * mean_phase[1] - r[1] * mean_phase[0]);
        amplitude_row[col] += std::sqrt(r.dot(r));
      }
      energy_row[col] += std::max(agreement - threshold, 0.0);
    }
  }
}

// The energy of noise alone: mean plus k standard deviations, as Kovesi derives it.
//
// White noise of power s^2 per bin passes a filter G with mean square s^2 sum G^2 / N^2 (Parseval),
// and the sum of the responses over the scales with s^2 sum (sum_n G_n)^2 / N^2: their ratio
// depends on the filters only. The finest scale sees mostly noise, features being sparse. The
// square of a complex Gaussian response is exponentially distributed; its median is ln 2 times its
// mean and robust against features. It gives the mean square of the finest scale and, with the
// ratio, that of the sum, E^2. The magnitude of the sum is then Rayleigh distributed with 2 tau^2 =
// E^2, mean tau sqrt(pi / 2) and standard deviation tau sqrt(2 - pi / 2).
double PhaseCongruency::noise_threshold(const cv::Mat& finest_response, int orientation) const {
  cv::Mat all_scales = cv::Mat::zeros(size_, CV_64FC1);
  for (const cv::Mat& filter : radial_) all_scales += filter;
  const double power_ratio = cv::norm(all_scales.mul(angular_[orientation]), cv::NORM_L2SQR) /
                             cv::norm(radial_[0].mul(angular_[orientation]), cv::NORM_L2SQR);
  const double finest_mean_square = median_squared_magnitude(finest_response) / std::log(2.0);
  const double tau = std::sqrt(0.5 * finest_mean_square * power_ratio);
  const double mean = tau * std::sqrt(kHalfPi);
  const double deviation = tau * std::sqrt(2.0 - kHalfPi);
  return (mean + kNoiseDeviations * deviation) / kNoiseOverestimate;
}

}  // namespace raywalk
