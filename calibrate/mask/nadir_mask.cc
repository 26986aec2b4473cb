#include "calibrate/mask/nadir_mask.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibrate/mask/dolly_detection.h"
#include "calibrate/mask/mask_report.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

constexpr double kWidestCone_deg = 89.0;
constexpr double kLeastValidShare = 0.01;
constexpr double kDark = 127.0;  // levels up to this are masked, as JPEG changes black a little

void require_cone(double cone_deg) {
  if (cone_deg >= 0.0 && cone_deg <= kWidestCone_deg) return;
  throw UsageError(fmt::format("a mask cannot reach {:g} degrees from the nadir; give 0 to {:g}",
                               cone_deg, kWidestCone_deg));
}

void mask_cone(double cone_deg, cv::Mat* mask) {
  const double highest = -kHalfPi + radians_from_degrees(cone_deg);
  for (int v = 0; v < mask->rows; ++v) {
    const PixelPosition pixel{0.0, static_cast<double>(v)};
    if (angles_from_pixel(pixel, {mask->cols, mask->rows}).phi_rad < highest) {
      mask->row(v).setTo(0);
    }
  }
}

cv::Mat read_scaled(const std::filesystem::path& file, cv::Size size) {
  const cv::Mat picture = read_mask(file, panorama_size_of(file));
  cv::Mat scaled;
  cv::resize(picture, scaled, size, 0.0, 0.0, cv::INTER_NEAREST);
  return scaled > kDark;
}

void require_unmasked_area(const cv::Mat& mask) {
  if (1.0 - masked_share(mask) >= kLeastValidShare) return;
  throw Error("the mask hides everything; draw the masked area black and all else white");
}

}  // namespace

double masked_share(const cv::Mat& mask) {
  double share = 0.0;
  for (int v = 0; v < mask.rows; ++v) {
    const double phi =
        angles_from_pixel({0.0, static_cast<double>(v)}, {mask.cols, mask.rows}).phi_rad;
    const int hidden = mask.cols - cv::countNonZero(mask.row(v));
    share += hidden * std::cos(phi) * kHalfPi / (static_cast<double>(mask.cols) * mask.rows);
  }
  return share;
}

cv::Mat make_mask(PanoramaSize size, const MaskOptions& options) {
  require_cone(options.cone_deg);
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(255));
  if (options.cone_deg > 0.0) mask_cone(options.cone_deg, &mask);
  if (options.picture) cv::bitwise_and(mask, read_scaled(*options.picture, mask.size()), mask);
  require_unmasked_area(mask);
  return mask;
}

std::optional<cv::Mat> write_mask(const CaptureSet& panoramas, const MaskOptions& options) {
  if (panoramas.layout != FrameLayout::kPanorama) {
    throw Error("masks need panoramas; run raywalk-calibrate stitch first");
  }
  cv::Mat mask = make_mask(panoramas.frame, options);
  std::optional<DollyDetection> dolly;
  if (options.automatic) {
    dolly = detect_dolly(panoramas);
    if (dolly) {
      cv::bitwise_and(mask, dolly->mask, mask);
    } else {
      spdlog::warn(
          "no dolly was detected under the camera; if there is one in view, give a cone or a "
          "picture of the mask");
    }
  }
  if (cv::countNonZero(mask) == mask.rows * mask.cols) {
    for (const char* name : {"mask.png", "mask.json", "mask.html"}) {
      std::filesystem::remove(options.out / name);
    }
    return std::nullopt;
  }
  require_unmasked_area(mask);
  const CaptureFrame& sample = panoramas.frames[panoramas.frames.size() / 2];
  const MaskReport report{options, masked_share(mask), sample.name, dolly};
  make_directories(options.out);
  write_file_atomically(options.out / "mask.html",
                        mask_page(report, mask, read_panorama(sample.file)));
  write_file_atomically(options.out / "mask.json", mask_json(report, panoramas.frame));
  write_image(options.out / "mask.png", mask);
  return mask;
}

}  // namespace raywalk::calibrate
