#include "calibrate/mask/mask_report.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

namespace raywalk::calibrate {
namespace {

constexpr int kFormatVersion = 1;
const cv::Scalar kTint(40, 40, 255);  // BGR

}  // namespace

nlohmann::ordered_json mask_document(const MaskReport& report, PanoramaSize size) {
  nlohmann::ordered_json document{{"format_version", kFormatVersion},
                                  {"width_px", size.width},
                                  {"height_px", size.height},
                                  {"masked_share", report.masked_share},
                                  {"cone_deg", report.options.cone_deg},
                                  {"picture", nullptr},
                                  {"automatic", nullptr},
                                  {"frame_masks", nullptr},
                                  {"station", report.station}};
  if (report.options.picture) document["picture"] = report.options.picture->string();
  if (report.dolly) {
    document["automatic"] = {{"reach_deg", report.dolly->reach_deg},
                             {"lines", report.dolly->lines},
                             {"stations", report.dolly->stations}};
  }
  if (report.of_frames.frames > 0) {
    document["frame_masks"] = {{"frames", report.of_frames.frames},
                               {"of_frames", report.frames},
                               {"masked_share", report.of_frames.share}};
  }
  return document;
}

cv::Mat tinted(const cv::Mat& mask, const cv::Mat& panorama) {
  cv::Mat tint(panorama.size(), panorama.type(), kTint), mixed;
  cv::addWeighted(panorama, 0.5, tint, 0.5, 0.0, mixed);
  cv::Mat shown = panorama.clone();
  mixed.copyTo(shown, mask == 0);
  return shown;
}

}  // namespace raywalk::calibrate
