#include "core/judge/validation/validation_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/report/json_page.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr double kHeadroom = 1.2;  // above the largest value of a plot with a given scale

// A table of `list` after the columns that name its rows; nothing where no truth has distances.
void add_silhouettes(const ordered_json& document, JsonPage page, const std::string& list,
                     std::vector<JsonColumn> columns, const std::string& caption) {
  if (document[list].empty() || !document[list][0].contains("specks_per_megapixel")) return;
  columns.insert(columns.end(), {{"near silhouettes / dB", "{psnr_near_silhouettes_db:.2f}"},
                                 {"elsewhere / dB", "{psnr_elsewhere_db:.2f}"},
                                 {"share near", "{near_silhouettes_share:.1%}"},
                                 {"specks per megapixel", "{specks_per_megapixel:.0f}"}});
  page.table(list, columns, caption);
}

void add_headline(const ordered_json& document, JsonPage page) {
  page.within("best").facts({{"mean PSNR, {generation}", "{psnr_db:.2f dB}"},
                             {"gain over initial views", "{gain_db:+.2f dB}", "gain_db"},
                             {"mean SSIM", "{ssim:.4f}"},
                             {"mean FSIM", "{fsim:.4f}"},
                             {"median time of a view", "{median_render_ms:.0f ms}"}});
  page.when("distances is none")
      .paragraph(
          "The room has no distances, so that only initial views could be rendered: the vertical "
          "parallax is not corrected. raywalk-build-lf depth estimates them.");
  page.table("modes",
             {{"generation", "{generation}"},
              {"connection", "{connection}"},
              {"k / deg", "{k_deg:g}"},
              {"PSNR / dB", "{psnr_db:.2f}", "largest psnr_db"},
              {"WS-PSNR / dB", "{ws_psnr_db:.2f}", "largest ws_psnr_db"},
              {"SSIM", "{ssim:.4f}", "largest ssim"},
              {"FSIM", "{fsim:.4f}", "largest fsim"},
              {"median time / ms", "{median_render_ms:.0f}"}},
             "Mean over all views; the best of each column is emphasised");
  add_silhouettes(document, page, "modes", {{"generation", "{generation}"}},
                  "PSNR within 2 pixels of true silhouettes, where the distances of neighbouring "
                  "pixels have a ratio above 1.15, and elsewhere; isolated wrong pixels (specks). "
                  "Mean over the views with true distances");
}

HtmlFigure jpeg_figure(const cv::Mat& image, const JsonPage& view, const std::string& caption) {
  const std::string text = view.text(caption);
  return picture_figure(image, EmbeddedFormat::kJpeg, view.text("{name}: ") + text, text);
}

// The truth, then a row of three pictures for every mode.
void add_sample(const PictureSample& sample, JsonPage page) {
  const std::size_t modes = sample.by_mode.size();
  const auto view_of = [&](std::size_t mode) {
    return page.within(fmt::format("views.{}", sample.truth * modes + mode));
  };
  view_of(0)
      .section(
          "{name} at ({x_m:g}, {z_m:g}) m, {line_distance_m as cm:.0f cm} from the nearest line")
      .figures({jpeg_figure(sample.truth_picture, view_of(0), "Ground truth")});
  for (std::size_t mode = 0; mode < modes; ++mode) {
    JsonPage view = view_of(mode);
    const ViewComparison& pictures = sample.by_mode[mode];
    view.figures(
        {jpeg_figure(pictures.view, view,
                     "{generation} view: PSNR {psnr_db:.2f dB}, SSIM {ssim:.3f}"),
         jpeg_figure(pictures.overlay, view, "{generation} view and ground truth, half and half"),
         jpeg_figure(pictures.error, view,
                     fmt::format("{{generation}} view: error, times {:g}", kErrorGain))});
  }
}

HtmlFigure over_distance(const JsonPage& page, const std::string& list, const std::string& key,
                         const std::string& label, const std::string& caption) {
  return page.plot({.x_label = "distance from the line / cm", .y_label = label},
                   {{list, "{generation}", "line_distance_m as cm", key, PlotStyle::kPoints}},
                   caption);
}

void add_gains(JsonPage page) {
  const JsonPage gains = page.when("quarter_gains");
  page.section("Quality over the distance from the line")
      .paragraph(
          "As Fig. 13 of the paper. Each point is the quarter of a view that faces a line, plotted "
          "over the distance from the viewpoint to that line: the vertical parallax grows with it, "
          "and so does the gain of correcting it.")
      .figures({over_distance(page, "quarters", "psnr_db", "PSNR / dB", "PSNR of every quarter"),
                over_distance(gains, "quarter_gains", "psnr_db", "gain in PSNR / dB",
                              "Gain in PSNR over the initial view"),
                over_distance(gains, "quarter_gains", "ssim", "gain in SSIM",
                              "Gain in SSIM over the initial view"),
                over_distance(gains, "quarter_gains", "fsim", "gain in FSIM",
                              "Gain in FSIM over the initial view")});
}

void add_connections(const ordered_json& document, const JsonPage& page) {
  if (document["connection"].is_null()) return;
  LinePlot axes{.x_label = "k / degrees",
                .y_label = "E_connect / squared 8-bit levels",
                .references = {{45.0, "LFU"}, {90.0, "Ray-space360"}}};
  const std::vector<JsonSeries> errors{
      {"/connection_error", "{generation}", "k_deg", "e_connect_plotted"}};
  std::vector<HtmlFigure> plots{page.plot(axes, errors, "E_connect over k")};
  // The corrected views lie far below the initial ones.
  if (const ordered_json largest = document["connection"]["corrected_up_to"]; !largest.is_null()) {
    axes.y_range = AxisRange{0.0, kHeadroom * largest.get<double>()};
    plots.push_back(
        page.plot(axes, errors, "E_connect over k, at the scale of the corrected views"));
  }
  page.within("connection")
      .section("How well neighbouring lines connect")
      .paragraph(
          "E_connect, equation (11) of the paper: the mean squared difference of 8-bit RGB between "
          "what the two lines of a corner show in an overlap of {overlap_deg:g} degrees, over the "
          "centres of {viewpoints} x {viewpoints} sub-cells of every cell. Smaller is better. A "
          "corner is readable where both lines captured part of its overlap; the first E_connect "
          "is over other corners at every k and compares none of them. \"common\" is over the "
          "{common_share:.0%} of the corners that are readable at every k; {comparable:the least "
          "of each generation is emphasised|too few to compare the angles for the room}.")
      .table("/connection_error",
             {{"generation", "{generation}"},
              {"connection", "{connection}"},
              {"k / deg", "{k_deg:g}"},
              {"corners read", "{coverage:.0%}"},
              {"E_connect", "{e_connect:.1f}"},
              {"common", "{e_connect_common:.1f}", "least"}},
             "E_connect over the limit angle k, as Table 2 of the paper")
      .figures(plots);
}

void add_views(const ordered_json& document, JsonPage page) {
  page.section("Every view")
      .table("views",
             {{"view", "{name}"},
              {"generation", "{generation}"},
              {"x / m", "{x_m:g}"},
              {"z / m", "{z_m:g}"},
              {"from line / cm", "{line_distance_m as cm:.1f}"},
              {"PSNR / dB", "{psnr_db:.2f}", "best.psnr_db"},
              {"WS-PSNR / dB", "{ws_psnr_db:.2f}", "best.ws_psnr_db"},
              {"SSIM", "{ssim:.4f}", "best.ssim"},
              {"FSIM", "{fsim:.4f}", "best.fsim"}},
             "The best generation of each view is emphasised");
  add_silhouettes(document, page, "views", {{"view", "{name}"}, {"generation", "{generation}"}},
                  "PSNR near true silhouettes and elsewhere, and specks, of every view");
  page.section("How the views were rendered");
  page.when("widest_truth_px > captured_width_px")
      .paragraph(
          "Views up to {widest_truth_px} pixels wide are enlarged "
          "{widest_truth_px / captured_width_px:.1f} times from panoramas of {captured_width_px}: "
          "they cannot show the detail of a truth of that width.");
  page.paragraphs("modes",
                  "{generation}: connection {connection} at k = {k_deg:g} degrees ({k_source}), "
                  "blended over {overlap_deg:g} degrees.");
  page.when("!distances is none").paragraph("Distances of the corrected views: {distances}.");
  page.paragraph(
          "In {limited_views} of {views:size} views at least one corner connects nearer to the "
          "physical connection than k requires, because the overhang of its lines runs out.")
      .table("views",
             {{"view", "{name}"},
              {"generation", "{generation}"},
              {"corners moved", "{limited_corners}"},
              {"filled", "{filled_share:.2%}"},
              {"unseen", "{unseen_share:.2%}"},
              {"empty", "{empty_share:.2%}"},
              {"time / ms", "{render_ms:.0f}"}},
             "Shares of pixels: filled from other stations because the lines in use do not see "
             "them, seen by no station, served by no line");
}

}  // namespace

std::string validation_report(const ordered_json& document,
                              const std::vector<PictureSample>& samples) {
  JsonPage page(document, "Validation of {volume}",
                document["views"].empty()
                    ? "connections of two rooms, without true views"
                    : "{truths:counted true viewpoint}, {modes:counted generation}");
  const JsonPage viewed = page.when("views");
  add_headline(document, viewed);
  if (document.contains("before_after")) add_before_after(page.within("before_after"));
  for (const PictureSample& sample : samples) add_sample(sample, page);
  add_gains(viewed);
  add_connections(document, page);
  add_views(document, viewed);
  return page.html();
}

}  // namespace raywalk
