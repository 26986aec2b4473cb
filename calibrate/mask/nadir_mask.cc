#include "calibrate/mask/nadir_mask.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/figures.h"
#include "calibrate/base/frame_masks.h"
#include "calibrate/mask/dolly_detection.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json.h"
#include "core/panorama/panorama_rotation.h"

namespace raywalk::calibrate {
namespace {

constexpr int kMaskVersion = 1;
constexpr double kWidestCone_deg = 89.0;
constexpr double kLeastValidShare = 0.01;

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
  const cv::Mat picture = read_mask(file, panorama_header_of(file).size);
  cv::Mat scaled;
  cv::resize(picture, scaled, size, 0.0, 0.0, cv::INTER_NEAREST);
  return scaled;
}

void require_unmasked_area(const cv::Mat& mask) {
  if (1.0 - masked_share(mask) >= kLeastValidShare) return;
  throw Error("the mask hides everything; draw the masked area black and all else white");
}

// The panorama, red where `mask` is 0.
cv::Mat tinted(const cv::Mat& mask, const cv::Mat& panorama) {
  const cv::Scalar kTint(40, 40, 255);  // BGR
  cv::Mat tint(panorama.size(), panorama.type(), kTint), mixed;
  cv::addWeighted(panorama, 0.5, tint, 0.5, 0.0, mixed);
  cv::Mat shown = panorama.clone();
  mixed.copyTo(shown, mask == 0);
  return shown;
}

// Shows it on the middle station's panorama, with its own mask.
void write_report(const CaptureSet& panoramas, const cv::Mat& mask,
                  const std::optional<DollyDetection>& dolly, const MaskOptions& options) {
  const std::size_t shown = panoramas.stations() / 2;
  const CaptureFrame& sample = panoramas.frames[shown];
  nlohmann::ordered_json document{{"format_version", kMaskVersion},
                                  {"width_px", panoramas.frame.width},
                                  {"height_px", panoramas.frame.height},
                                  {"masked_share", masked_share(mask)},
                                  {"cone_deg", options.cone_deg},
                                  {"picture", nullptr},
                                  {"automatic", nullptr},
                                  {"frame_masks", nullptr},
                                  {"station", sample.name}};
  if (options.picture) document["picture"] = options.picture->string();
  if (dolly) {
    document["automatic"] = {
        {"reach_deg", dolly->reach_deg}, {"lines", dolly->lines}, {"stations", dolly->stations}};
  }
  const MaskFigures of_frames = mask_figures(panoramas, mask);
  if (of_frames.frames > 0) {
    document["frame_masks"] = {{"frames", of_frames.frames},
                               {"of_frames", panoramas.frames.size()},
                               {"masked_share", of_frames.share}};
  }
  const cv::Mat joint = joint_mask(panoramas, static_cast<int>(shown), mask);
  document["figures"] = nlohmann::ordered_json::array(
      {write_figure(options.out, "mask", "Station " + sample.name, "red: masked",
                    tinted(joint, read_panorama(sample.file)))});
  write_file_atomically(options.out / "mask.json", json_text(document));
}

}  // namespace

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
  const bool masks_nothing = cv::countNonZero(mask) == mask.rows * mask.cols;
  if (masks_nothing) {
    for (const char* name : {"mask.png", "mask.json", "figures/mask.png"}) {
      std::filesystem::remove(options.out / name);
    }
    if (!any_masks(panoramas)) return std::nullopt;
  } else {
    require_unmasked_area(mask);
  }
  make_directories(options.out);
  write_report(panoramas, mask, dolly, options);
  if (masks_nothing) return std::nullopt;
  write_image(options.out / "mask.png", mask);
  return mask;
}

}  // namespace raywalk::calibrate
