#include "calibrate/stitch/stitch_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/report/html_page.h"
#include "core/report/svg_plot.h"

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

std::string falloff_plot(const BalanceFit& fit) {
  LinePlot plot{.title = "Light over the angle from a lens's axis",
                .x_label = "angle / degrees",
                .y_label = "share of the light on the axis",
                .series = {{.name = "both lenses"}}};
  for (int angle = 0; angle <= 95; ++angle) {
    plot.series[0].points.push_back(
        {static_cast<double>(angle), fit.balance.share_at(radians_from_degrees(angle))});
  }
  plot.y_range = AxisRange{0.0, 1.2};
  return svg_from_plot(plot);
}

void add_balance(const StitchRecord& record, HtmlPage* page) {
  const BalanceFit& fit = record.balance.fit;
  const auto& bgr = fit.balance.back_gain;
  page->add_section("Balance of the lenses");
  page->add_paragraph(fmt::format(
      "Measured once for all frames, in {} of them: at {} points seen by both lenses, and at {} "
      "seen by one lens from two stations. The overlap determines the gain and the slope of the "
      "falloff at the rim; points that move through the picture determine the falloff further in.",
      record.balance.frames, record.balance.overlap_ratios, record.balance.motion_ratios));
  page->add_table({.caption = "Standard deviations follow from the scatter of the ratios",
                   .header = {"figure", "value", "standard deviation"},
                   .rows = {{{"light of the back lens over the front's, red"},
                             {fmt::format("{:.4f}", bgr[2])},
                             {fmt::format("{:.4f}", fit.gain_sigma * bgr[2])}},
                            {{"green"},
                             {fmt::format("{:.4f}", bgr[1])},
                             {fmt::format("{:.4f}", fit.gain_sigma * bgr[1])}},
                            {{"blue"},
                             {fmt::format("{:.4f}", bgr[0])},
                             {fmt::format("{:.4f}", fit.gain_sigma * bgr[0])}},
                            {{"light at 45 degrees from the axis"},
                             {fmt::format("{:.4f}", fit.balance.share_at(0.25 * kPi))},
                             {fmt::format("{:.4f}", fit.share_45_sigma)}},
                            {{"light at 90 degrees"},
                             {fmt::format("{:.4f}", fit.balance.share_at(kHalfPi))},
                             {fmt::format("{:.4f}", fit.share_90_sigma)}}}});
  page->add_figures({svg_figure(falloff_plot(fit), "Vignetting that is corrected")});
}

}  // namespace

std::string stitch_page(const StitchRecord& record, const StitchSample& sample) {
  HtmlPage page("Stitched panoramas",
                fmt::format("{} frames, {} x {}, {} blend over {:g} degrees", record.frames,
                            record.panorama.width, record.panorama.height,
                            name_of(record.options.blend), record.options.blend_deg));
  page.add_facts(
      {{"step at the seam before", fmt::format("{:.2f} levels", record.balance.step_before_levels)},
       {"after balancing", fmt::format("{:.2f} levels", record.balance.step_after_levels)},
       {"correlation of the lenses along the seam",
        fmt::format("{:.3f}", record.balance.correlation)}});
  page.add_paragraph(
      "The step is the median difference of brightness between the lenses in their overlap. The "
      "correlation is that of their levels there (1 is perfect; near objects lower it by "
      "parallax). "
      "Both are medians over the frames used.");
  for (const std::string& warning : record.balance.warnings)
    page.add_paragraph("Warning: " + warning);
  page.add_section("Station " + sample.station);
  page.add_figures({shown(sample.panorama, "The panorama")});
  std::vector<HtmlFigure> crops;
  for (const double theta_deg : {-90.0, 90.0}) {
    const std::string place = fmt::format("Seam at {:g} degrees", theta_deg);
    crops.push_back(shown(seam_crop(sample.unbalanced, theta_deg), place + ", as captured"));
    crops.push_back(shown(seam_crop(sample.panorama, theta_deg), place + ", balanced and blended"));
  }
  page.add_figures(crops);
  add_balance(record, &page);
  return page.html();
}

}  // namespace raywalk::calibrate
