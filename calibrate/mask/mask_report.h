// mask.json and its figure.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "calibrate/base/frame_masks.h"
#include "calibrate/mask/dolly_detection.h"
#include "calibrate/mask/nadir_mask.h"

namespace raywalk::calibrate {

struct MaskReport {
  MaskOptions options{};
  double masked_share = 0.0;  // of the sphere, in all frames
  std::string station{};      // that the figure shows
  std::optional<DollyDetection> dolly{};
  int frames = 0;           // of the capture
  MaskFigures of_frames{};  // masks of single frames
};

// Of mask.json. Keys: format_version, width_px, height_px, masked_share, cone_deg, picture (null:
// none), automatic (null: disabled, or nothing found) {reach_deg, lines, stations}, frame_masks
// (null: no frame has a mask of its own) {frames, of_frames, masked_share (with the common mask,
// mean)}, station; write_mask adds figures.
nlohmann::ordered_json mask_document(const MaskReport& report, PanoramaSize size);

// The panorama of a station (CV_8UC3), red where `mask`, of the same size, is 0.
cv::Mat tinted(const cv::Mat& mask, const cv::Mat& panorama);

}  // namespace raywalk::calibrate
