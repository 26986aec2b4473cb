#include "calibrate/mask/mask_report.h"

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/report/json_page.h"

namespace raywalk::calibrate {
namespace {

constexpr int kFormatVersion = 1;
constexpr int kShownWidth_px = 1600;
const cv::Scalar kTint(40, 40, 255);  // BGR

cv::Mat tinted(const cv::Mat& mask, const cv::Mat& panorama) {
  cv::Mat tint(panorama.size(), panorama.type(), kTint), mixed;
  cv::addWeighted(panorama, 0.5, tint, 0.5, 0.0, mixed);
  cv::Mat shown = panorama.clone();
  mixed.copyTo(shown, mask == 0);
  if (shown.cols > kShownWidth_px) {
    cv::resize(shown, shown, {kShownWidth_px, kShownWidth_px / 2}, 0.0, 0.0, cv::INTER_AREA);
  }
  return shown;
}

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

std::string mask_page(const nlohmann::ordered_json& document, const cv::Mat& mask,
                      const cv::Mat& panorama) {
  JsonPage page(document, "Mask of the frames",
                "{!frame_masks:The same in every frame: it hides what moves with the camera|What "
                "moves with the camera, and what the frames' own masks hide}");
  page.facts({{"of the sphere is masked{!frame_masks:| in all frames}", "{masked_share:.2%}"},
              {"frames with a mask of their own", "{frame_masks.frames} of {frame_masks.of_frames}",
               "frame_masks"},
              {"of their sphere is masked", "{frame_masks.masked_share:.2%}", "frame_masks"},
              {"cone about the nadir", "{cone_deg:g degrees}", "cone_deg"},
              {"reach of the detected dolly", "{automatic.reach_deg:.1f degrees}", "automatic"}});
  page.when("picture").paragraph("Picture: {picture}");
  page.within("automatic")
      .paragraph("The dolly was detected from {stations} stations of {lines:counted line}.");
  const std::string caption = page.text("Station {station}; red: masked");
  page.figures({picture_figure(tinted(mask, panorama), EmbeddedFormat::kJpeg, caption, caption)});
  return page.html();
}

}  // namespace raywalk::calibrate
