#include "calibrate/stitch/stitch_page.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "core/report/json_page.h"

namespace raywalk::calibrate {
namespace {

constexpr int kShownWidth_px = 1600;
constexpr int kSmallestCrop_px = 320;  // enlarged to this
constexpr double kCropSpan_deg = 40.0;

HtmlFigure shown(const cv::Mat& picture, const std::string& caption) {
  cv::Mat small = picture;
  if (picture.cols > kShownWidth_px) {
    const double scale = static_cast<double>(kShownWidth_px) / picture.cols;
    cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
  }
  return picture_figure(small, EmbeddedFormat::kJpeg, caption, caption);
}

// Around the horizon at a longitude of +-90 degrees, where the seam crosses it.
cv::Mat seam_crop(const cv::Mat& panorama, double theta_deg) {
  const int side = static_cast<int>(panorama.cols * kCropSpan_deg / 360.0);
  const int centre = static_cast<int>(panorama.cols * (0.5 + theta_deg / 360.0));
  const cv::Rect crop(centre - side / 2, panorama.rows / 2 - side / 2, side, side);
  cv::Mat shown = panorama(crop).clone();
  if (side < kSmallestCrop_px) {
    cv::resize(shown, shown, {kSmallestCrop_px, kSmallestCrop_px}, 0.0, 0.0, cv::INTER_CUBIC);
  }
  return shown;
}

std::vector<HtmlFigure> seam_crops(const StitchSample& sample) {
  std::vector<HtmlFigure> crops;
  for (const double theta_deg : {-90.0, 90.0}) {
    const std::string place = fmt::format("Seam at {:g} degrees", theta_deg);
    crops.push_back(shown(seam_crop(sample.unbalanced, theta_deg), place + ", as captured"));
    crops.push_back(shown(seam_crop(sample.panorama, theta_deg), place + ", balanced and blended"));
  }
  return crops;
}

void add_balance(JsonPage page) {
  const auto row = [](const std::string& name, const std::string& value, const std::string& sigma) {
    return JsonRows{.cells = {{name}, {"{" + value + ":.4f}"}, {"{" + sigma + ":.2g%}"}}};
  };
  const LinePlot axes{.title = "Light over the angle from a lens's axis",
                      .x_label = "angle / degrees",
                      .y_label = "share of the light on the axis",
                      .y_range = AxisRange{0.0, 1.2}};
  page.section("Balance of the lenses")
      .paragraph(
          "Measured once for all frames, in {frames} of them: at {overlap_ratios} points seen by "
          "both lenses, and at {motion_ratios} seen by one lens from two stations. The overlap "
          "determines the gain and the slope of the falloff at the rim; points that move through "
          "the picture determine the falloff further in.")
      .table({.caption = "Standard deviations are shares of the values, from the scatter of the "
                         "ratios",
              .header = {"figure", "value", "standard deviation"},
              .rows = {row("light of the back lens over the front's, red", "back_gain.0",
                           "gain_sigma"),
                       row("green", "back_gain.1", "gain_sigma"),
                       row("blue", "back_gain.2", "gain_sigma"),
                       row("light at 45 degrees from the axis", "share_45", "share_45_sigma"),
                       row("light at 90 degrees", "share_90", "share_90_sigma")}})
      .figures({page.plot(axes, {{"light", "both lenses", "angle_deg", "share", PlotStyle::kLine}},
                          "Vignetting that is corrected")});
}

}  // namespace

std::string stitch_page(const nlohmann::ordered_json& document, const StitchSample& sample) {
  JsonPage page(document, "Stitched panoramas",
                "{frames} frames, {width_px} x {height_px}, {blend} blend over {blend_deg:g} "
                "degrees");
  page.within("seam")
      .facts({{"step at the seam before", "{step_before_levels:.2f levels}"},
              {"after balancing", "{step_after_levels:.2f levels}"},
              {"correlation of the lenses along the seam", "{correlation:.3f}"}})
      .paragraph(
          "The step is the median difference of brightness between the lenses in their overlap. "
          "The correlation is that of their levels there (1 is perfect; near objects lower it by "
          "parallax). Both are medians over the frames used.");
  page.warnings("warnings");
  page.section("One of the panoramas")
      .figures({shown(sample.panorama, "Station " + sample.station)})
      .figures(seam_crops(sample));
  add_balance(page.within("balance"));
  return page.html();
}

}  // namespace raywalk::calibrate
