// mask.json and mask.html.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "calibrate/mask/dolly_detection.h"
#include "calibrate/mask/nadir_mask.h"

namespace raywalk::calibrate {

struct MaskReport {
  MaskOptions options{};
  double masked_share = 0.0;  // of the sphere
  std::string station{};      // shown on the page
  std::optional<DollyDetection> dolly{};
};

// Keys: format_version, width_px, height_px, masked_share, cone_deg, picture (null: none),
// automatic (null: disabled, or nothing found) {reach_deg, lines, stations}.
std::string mask_json(const MaskReport& report, PanoramaSize size);

// `panorama` is that of the station, CV_8UC3, of the mask's size.
std::string mask_page(const MaskReport& report, const cv::Mat& mask, const cv::Mat& panorama);

}  // namespace raywalk::calibrate
