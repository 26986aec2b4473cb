#include "calibrate/mask/mask_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "core/report/html_page.h"

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

std::string mask_json(const MaskReport& report, PanoramaSize size) {
  nlohmann::ordered_json json{{"format_version", kFormatVersion},
                              {"width_px", size.width},
                              {"height_px", size.height},
                              {"masked_share", report.masked_share},
                              {"cone_deg", report.options.cone_deg},
                              {"picture", nullptr},
                              {"automatic", nullptr}};
  if (report.options.picture) json["picture"] = report.options.picture->string();
  if (report.dolly) {
    json["automatic"] = {{"reach_deg", report.dolly->reach_deg},
                         {"lines", report.dolly->lines},
                         {"stations", report.dolly->stations}};
  }
  if (report.of_frames.frames > 0) {
    json["frame_masks"] = {{"frames", report.of_frames.frames},
                           {"of_frames", report.frames},
                           {"masked_share", report.of_frames.share}};
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string mask_page(const MaskReport& report, const cv::Mat& mask, const cv::Mat& panorama) {
  HtmlPage page("Mask of the frames",
                report.of_frames.frames > 0
                    ? "What moves with the camera, and what the frames' own masks hide"
                    : "The same in every frame: it hides what moves with the camera");
  std::vector<HtmlFact> facts{
      {"of the sphere is masked", fmt::format("{:.2f} %", 100.0 * report.masked_share)}};
  if (report.of_frames.frames > 0) {
    facts.front().name = "of the sphere is masked in all frames";
    facts.push_back({"frames with a mask of their own",
                     fmt::format("{} of {}", report.of_frames.frames, report.frames)});
    facts.push_back(
        {"of their sphere is masked", fmt::format("{:.2f} %", 100.0 * report.of_frames.share)});
  }
  if (report.options.cone_deg > 0.0) {
    facts.push_back({"cone about the nadir", fmt::format("{:g} degrees", report.options.cone_deg)});
  }
  if (report.dolly) {
    facts.push_back(
        {"reach of the detected dolly", fmt::format("{:.1f} degrees", report.dolly->reach_deg)});
  }
  page.add_facts(facts);
  if (report.options.picture) page.add_paragraph("Picture: " + report.options.picture->string());
  if (report.dolly) {
    page.add_paragraph(fmt::format("The dolly was detected from {} stations of {} lines.",
                                   report.dolly->stations, report.dolly->lines));
  }
  const std::string caption = "Station " + report.station + "; red: masked";
  page.add_figures(
      {picture_figure(tinted(mask, panorama), EmbeddedFormat::kJpeg, caption, caption)});
  return page.html();
}

}  // namespace raywalk::calibrate
