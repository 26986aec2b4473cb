#include "core/evaluate/fsim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel.h"
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
  cv::Mat means, out;
  cv::boxFilter(with_border(image, factor), means, CV_64F, {factor, factor}, {before, before});
  const cv::Size size((image.cols + factor - 1) / factor, (image.rows + factor - 1) / factor);
  const cv::Rect whole(factor, factor, size.width * factor, size.height * factor);
  cv::resize(means(whole), out, size, 0.0, 0.0, cv::INTER_NEAREST);
  return out;
}

// Magnitude of the Scharr gradient, in levels per two pixels as the paper's kernels (weights 3, 10,
// 3 over 16) give it.
cv::Mat gradient_magnitude(const cv::Mat& image) {
  const cv::Mat framed = with_border(image, 1);
  cv::Mat along_x, along_y, magnitude;
  cv::Scharr(framed, along_x, CV_64F, 1, 0, 1.0 / 16.0);
  cv::Scharr(framed, along_y, CV_64F, 0, 1, 1.0 / 16.0);
  cv::magnitude(along_x, along_y, magnitude);
  return magnitude(cv::Rect(1, 1, image.cols, image.rows));
}

cv::Mat similarity(const cv::Mat& a, const cv::Mat& b, double constant) {
  return (2.0 * a.mul(b) + constant) / (a.mul(a) + b.mul(b) + constant);
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

struct Response {
  cv::Mat even, odd;  // real and imaginary part
};

Response filtered(const cv::Mat& spectrum, const cv::Mat& filter) {
  cv::Mat both, response;
  cv::merge(std::array{filter, filter}, both);
  cv::idft(spectrum.mul(both), response, cv::DFT_SCALE);
  std::array<cv::Mat, 2> parts;
  cv::split(response, parts.data());
  return {parts[0], parts[1]};
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
double noise_threshold(const Response& finest, double power_ratio) {
  const cv::Mat squares = finest.even.mul(finest.even) + finest.odd.mul(finest.odd);
  const double finest_mean_square =
      median({squares.begin<double>(), squares.end<double>()}) / std::log(2.0);
  const double tau = std::sqrt(0.5 * finest_mean_square * power_ratio);
  const double mean = tau * std::sqrt(kHalfPi);
  const double deviation = tau * std::sqrt(2.0 - kHalfPi);
  return (mean + kNoiseDeviations * deviation) / kNoiseOverestimate;
}

// Phase congruency: how far the Fourier components of an image agree in phase at a pixel, whatever
// their strength. FSIM uses it as the weight of a pixel: high at steps, lines and corners, 0 in
// flat regions.
//
// Kovesi's measure (Image Features from Phase Congruency, Videre 1(3), 1999) with the settings of
// FSIM: log-Gabor filters at 4 scales and 4 orientations, shortest wavelength 6 pixels, factor 2
// between scales. The filters are built once for both images.
class PhaseCongruency {
 public:
  explicit PhaseCongruency(cv::Size size) {
    std::array<cv::Mat, kScales> radial;
    double wavelength_px = kShortestWavelength_px;
    for (cv::Mat& filter : radial) {
      filter = log_gabor(size, 1.0 / wavelength_px);
      wavelength_px *= kScaleFactor;
    }
    const double spacing_rad = kPi / kOrientations;
    for (int i = 0; i < kOrientations; ++i) {
      Orientation& orientation = orientations_.at(i);
      const cv::Mat angular =
          angular_window(size, i * spacing_rad, spacing_rad / kSpacingOverSpread);
      cv::Mat sum = cv::Mat::zeros(size, CV_64FC1);
      for (int scale = 0; scale < kScales; ++scale) {
        orientation.filters.at(scale) = radial.at(scale).mul(angular);
        sum += orientation.filters.at(scale);
      }
      orientation.power_ratio =
          cv::norm(sum, cv::NORM_L2SQR) / cv::norm(orientation.filters.front(), cv::NORM_L2SQR);
    }
  }

  // Of a CV_64FC1 image in 8-bit levels: CV_64FC1 in [0, 1]. The image is treated as periodic in
  // both directions, as the Fourier transform does: true for the longitude of a panorama, an
  // assumption for its latitude.
  //
  // PC = sum over orientations of energy / (epsilon + sum over orientations and scales of
  // amplitude).
  //
  // With the responses R_n of the scales as complex numbers, A_n = |R_n| and the unit vector u
  // along their sum, the mean phase: a scale that is off the mean phase by delta_n contributes
  //   A_n (cos delta_n - |sin delta_n|) = R_n . u - |R_n x u|,
  // which falls off linearly around agreement, where the cosine alone would not (Kovesi's sharper
  // measure). The noise threshold is subtracted from the sum; negative results count as 0.
  cv::Mat operator()(const cv::Mat& grey) const {
    // Without the mean, which no filter passes and which would only leave rounding errors on flat
    // images.
    cv::Mat spectrum;
    cv::dft(grey - cv::mean(grey), spectrum, cv::DFT_COMPLEX_OUTPUT);
    cv::Mat energy = cv::Mat::zeros(grey.size(), CV_64FC1);
    cv::Mat amplitude(grey.size(), CV_64FC1, cv::Scalar::all(kEpsilon));
    for (const Orientation& orientation : orientations_) {
      std::array<Response, kScales> responses;
      cv::Mat u_even = cv::Mat::zeros(grey.size(), CV_64FC1), u_odd = u_even.clone();
      cv::Mat magnitude;
      for (int scale = 0; scale < kScales; ++scale) {
        Response& response = responses.at(scale);
        response = filtered(spectrum, orientation.filters.at(scale));
        u_even += response.even;
        u_odd += response.odd;
        cv::magnitude(response.even, response.odd, magnitude);
        amplitude += magnitude;
      }
      cv::magnitude(u_even, u_odd, magnitude);
      magnitude += kEpsilon;
      u_even /= magnitude;
      u_odd /= magnitude;
      cv::Mat agreement(grey.size(), CV_64FC1,
                        cv::Scalar(-noise_threshold(responses.front(), orientation.power_ratio)));
      for (const auto& [even, odd] : responses) {
        agreement += even.mul(u_even) + odd.mul(u_odd) - cv::abs(even.mul(u_odd) - odd.mul(u_even));
      }
      energy += cv::max(agreement, 0.0);
    }
    return energy / amplitude;
  }

 private:
  static constexpr int kScales = 4;
  static constexpr int kOrientations = 4;

  struct Orientation {
    std::array<cv::Mat, kScales> filters;  // transfer functions, CV_64FC1 in the order of cv::dft
    double power_ratio = 0.0;  // of their sum to the finest: what noise has through each
  };

  std::array<Orientation, kOrientations> orientations_;
};

}  // namespace

FeatureSimilarity feature_similarity(const cv::Mat& a, const cv::Mat& b) {
  require_image_pair(a, b, kMinSide_px);
  const int factor =
      std::max(1, static_cast<int>(std::lround(std::min(a.rows, a.cols) / kWorkingSide_px)));
  const std::array images{reduced(luma_of(a), factor), reduced(luma_of(b), factor)};
  const PhaseCongruency congruency_of(images[0].size());
  std::array<cv::Mat, 2> congruency, gradient;
  parallel_for(0, 2, 1, [&](int i, int) {
    congruency.at(i) = congruency_of(images.at(i));
    gradient.at(i) = gradient_magnitude(images.at(i));
  });
  const cv::Mat weight = cv::max(congruency[0], congruency[1]);
  const cv::Mat similar =
      similarity(gradient[0], gradient[1], kT2).mul(similarity(congruency[0], congruency[1], kT1));
  return {similar.mul(weight), weight};
}

double fsim(const FeatureSimilarity& features) {
  const double weight_sum = cv::sum(features.weight)[0];
  return weight_sum == 0.0 ? 1.0 : cv::sum(features.weighted)[0] / weight_sum;
}

double fsim(const cv::Mat& a, const cv::Mat& b) { return fsim(feature_similarity(a, b)); }

}  // namespace raywalk
