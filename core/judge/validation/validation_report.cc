#include "core/judge/validation/validation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/judge/validation/validation_plots.h"
#include "core/report/html_page.h"
#include "core/report/markup.h"

namespace raywalk {
namespace {

constexpr const char* kNotMeasured = "–";

std::string mode_name(const ViewMode& mode) { return generation_name(mode.options.generation); }

const ValidatedView& view_at(const Validation& validation, std::size_t truth, std::size_t mode) {
  return validation.views[truth * validation.modes.size() + mode];
}

std::string percent(double share) { return fmt::format("{:.2f} %", 100.0 * share); }

std::string place_of(const TruthView& truth) {
  return fmt::format("{} at ({:g}, {:g}) m, {:.0f} cm from the nearest line", truth.name,
                     truth.viewpoint.x_m, truth.viewpoint.z_m, 100.0 * truth.line_distance_m);
}

// Index of the mode with the largest mean PSNR.
std::size_t best_mode(const Validation& validation) {
  std::size_t best = 0;
  for (std::size_t mode = 1; mode < validation.modes.size(); ++mode) {
    if (mean_scores(validation, mode).psnr_db > mean_scores(validation, best).psnr_db) best = mode;
  }
  return best;
}

// A row of a name and its numbers; the largest is emphasised.
std::vector<HtmlCell> row_of(std::string name, const std::vector<double>& values, int decimals) {
  std::vector<HtmlCell> row{{std::move(name)}};
  const double largest = *std::max_element(values.begin(), values.end());
  for (const double value : values) {
    row.push_back({number_or_dash(value, decimals), values.size() > 1 && value == largest});
  }
  return row;
}

std::vector<double> render_times(const Validation& validation, std::size_t mode) {
  std::vector<double> times_ms;
  for (const ValidatedView& view : validation.views) {
    if (view.mode == mode) times_ms.push_back(view.report.render_ms);
  }
  return times_ms;
}

void add_headline(const Validation& validation, HtmlPage& page) {
  const std::size_t best = best_mode(validation);
  const ViewScores scores = mean_scores(validation, best);
  std::vector<HtmlFact> facts{{"mean PSNR, " + mode_name(validation.modes[best]),
                               number_or_dash(scores.psnr_db, 2) + " dB"}};
  const auto initial = initial_mode(validation);
  if (initial && *initial != best) {
    const double gain_db = scores.psnr_db - mean_scores(validation, *initial).psnr_db;
    facts.push_back({"gain over initial views", fmt::format("{:+.2f} dB", gain_db)});
  }
  facts.push_back({"mean SSIM", number_or_dash(scores.ssim, 4)});
  facts.push_back({"mean FSIM", number_or_dash(scores.fsim, 4)});
  facts.push_back(
      {"median time of a view", fmt::format("{:.0f} ms", median(render_times(validation, best)))});
  page.add_facts(facts);
  if (!validation.has_distances) {
    page.add_paragraph(
        "The room has no distances, so that only initial views could be rendered: the vertical "
        "parallax is not corrected. raywalk-build-lf depth estimates them.");
  }
}

void add_means(const Validation& validation, HtmlPage& page) {
  HtmlTable table{.caption = "Mean over all views; the best of each column is emphasised",
                  .header = {"generation", "connection", "k / deg"}};
  for (const ViewMode& mode : validation.modes) {
    table.rows.push_back(
        {{mode_name(mode)}, {mode.connection}, {fmt::format("{:g}", mode.options.k_deg)}});
  }
  for (const NamedScore& column : kNamedScores) {
    table.header.push_back(column.heading);
    std::vector<double> means;
    for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
      means.push_back(mean_scores(validation, mode).*column.member);
    }
    const double best = *std::max_element(means.begin(), means.end());
    for (std::size_t mode = 0; mode < means.size(); ++mode) {
      table.rows[mode].push_back(
          {number_or_dash(means[mode], column.decimals), means.size() > 1 && means[mode] == best});
    }
  }
  table.header.push_back("median time / ms");
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    table.rows[mode].push_back({number_or_dash(median(render_times(validation, mode)), 0)});
  }
  page.add_table(table);
}

HtmlFigure jpeg_figure(const cv::Mat& image, const std::string& of, const std::string& caption) {
  return picture_figure(image, EmbeddedFormat::kJpeg, of + ": " + caption, caption);
}

// The truth, then a row of three pictures for every mode.
void add_sample(const Validation& validation, const PictureSample& sample, HtmlPage& page) {
  const TruthView& truth = validation.truths[sample.truth];
  page.add_section(place_of(truth));
  page.add_figures({jpeg_figure(sample.truth_picture, truth.name, "Ground truth")});
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    const std::string name = mode_name(validation.modes[mode]);
    const ViewScores& scores = view_at(validation, sample.truth, mode).scores;
    const ViewComparison& pictures = sample.by_mode[mode];
    page.add_figures(
        {jpeg_figure(pictures.view, truth.name,
                     fmt::format("{} view: PSNR {:.2f} dB, SSIM {:.3f}", name, scores.psnr_db,
                                 scores.ssim)),
         jpeg_figure(pictures.overlay, truth.name, name + " view and ground truth, half and half"),
         jpeg_figure(pictures.error, truth.name,
                     fmt::format("{} view: error, times {:g}", name, kErrorGain))});
  }
}

void add_gains(const Validation& validation, HtmlPage& page) {
  page.add_section("Quality over the distance from the line");
  page.add_paragraph(
      "As Fig. 13 of the paper. Each point is the quarter of a view that faces a line, plotted "
      "over "
      "the distance from the viewpoint to that line: the vertical parallax grows with it, and so "
      "does the gain of correcting it.");
  std::vector<HtmlFigure> figures{
      svg_figure(metric_plot(validation, kQuarterPsnr), "PSNR of every quarter")};
  if (initial_mode(validation) && validation.modes.size() > 1) {
    for (const QuarterMetric& metric : {kQuarterPsnr, kQuarterSsim, kQuarterFsim}) {
      figures.push_back(svg_figure(gain_plot(validation, metric),
                                   fmt::format("Gain in {} over the initial view", metric.name)));
    }
  }
  page.add_figures(figures);
}

// The numbers of a column; the least is emphasised where the rows are over the same corners and
// these are enough to compare.
std::vector<HtmlCell> column_over_k(const ConnectError& measured, double ConnectErrorRow::*member) {
  double least = std::nan("");
  const bool comparable =
      member == &ConnectErrorRow::e_connect_common && measured.common_share >= kLeastCommonShare;
  if (comparable) {
    for (const ConnectErrorRow& row : measured.rows) least = std::fmin(least, row.*member);
  }
  std::vector<HtmlCell> column;
  column.reserve(measured.rows.size());
  for (const ConnectErrorRow& row : measured.rows) {
    column.push_back({number_or_dash(row.*member, 1), row.*member == least});
  }
  return column;
}

HtmlTable connection_error_table(const Validation& validation) {
  HtmlTable table{.caption = "E_connect over the limit angle k, as Table 2 of the paper",
                  .header = {"connection", "k / deg"}};
  const std::vector<ConnectErrorRow>& first = validation.connection_error.front().rows;
  for (const ConnectErrorRow& row : first) {
    table.rows.push_back({{row.connection}, {fmt::format("{:g}", row.k_deg)}});
  }
  const auto add_column = [&table](const std::string& heading,
                                   const std::vector<HtmlCell>& column) {
    table.header.push_back(heading);
    for (std::size_t i = 0; i < column.size(); ++i) table.rows[i].push_back(column[i]);
  };
  for (const ConnectError& measured : validation.connection_error) {
    const std::string name = generation_name(measured.generation);
    add_column(name, column_over_k(measured, &ConnectErrorRow::e_connect));
    add_column(name + ", common", column_over_k(measured, &ConnectErrorRow::e_connect_common));
  }
  std::vector<HtmlCell> coverage;
  coverage.reserve(first.size());
  for (const ConnectErrorRow& row : first) {
    coverage.push_back({number_or_dash(100.0 * row.coverage, 0) + " %"});
  }
  add_column("corners read", coverage);
  return table;
}

void add_connection_error(const Validation& validation, HtmlPage& page) {
  if (validation.connection_error.empty()) return;
  const ConnectErrorOptions& options = validation.connection_error.front().options;
  const double common_share = validation.connection_error.front().common_share;
  page.add_section("How well neighbouring lines connect");
  page.add_paragraph(fmt::format(
      "E_connect, equation (11) of the paper: the mean squared difference of 8-bit RGB between "
      "what the two lines of a corner show in an overlap of {1:g} degrees, over the centres of "
      "{0} x {0} sub-cells of every cell. Smaller is better. A corner is readable where both lines "
      "captured part of its overlap; the first column of a generation is over other corners at "
      "every k and compares none of them. \"common\" is over the {2:.0f} % of the corners that are "
      "readable at every k; {3}.",
      options.viewpoints, options.overlap_deg, 100.0 * common_share,
      common_share >= kLeastCommonShare ? "its least is emphasised"
                                        : "too few to compare the angles for the room"));
  page.add_table(connection_error_table(validation));
  std::vector<HtmlFigure> figures{
      svg_figure(connection_error_plot(validation), "E_connect over k")};
  if (const auto closer = corrected_connection_error_plot(validation)) {
    figures.push_back(svg_figure(*closer, "E_connect over k, at the scale of the corrected views"));
  }
  page.add_figures(figures);
}

void add_view_table(const Validation& validation, const NamedScore& column, HtmlPage& page) {
  HtmlTable table{.caption = column.heading,
                  .header = {"view", "x / m", "z / m", "from line / cm"}};
  for (const ViewMode& mode : validation.modes) table.header.push_back(mode_name(mode));
  for (std::size_t t = 0; t < validation.truths.size(); ++t) {
    const TruthView& truth = validation.truths[t];
    std::vector<double> values;
    for (std::size_t m = 0; m < validation.modes.size(); ++m) {
      values.push_back(view_at(validation, t, m).scores.*column.member);
    }
    std::vector<HtmlCell> row = row_of(truth.name, values, column.decimals);
    row.insert(row.begin() + 1, {{fmt::format("{:g}", truth.viewpoint.x_m)},
                                 {fmt::format("{:g}", truth.viewpoint.z_m)},
                                 {number_or_dash(100.0 * truth.line_distance_m, 1)}});
    table.rows.push_back(std::move(row));
  }
  page.add_table(table);
}

void add_making(const Validation& validation, HtmlPage& page) {
  page.add_section("How the views were rendered");
  const int widest_px = widest_truth_px(validation);
  if (widest_px > validation.captured_width_px) {
    page.add_paragraph(fmt::format(
        "Views up to {} pixels wide are enlarged {:.1f} times from panoramas of {}: they cannot "
        "show the detail of a truth of that width.",
        widest_px, enlargement_at(validation, widest_px), validation.captured_width_px));
  }
  for (const ViewMode& mode : validation.modes) {
    page.add_paragraph(
        fmt::format("{}: connection {} at k = {:g} degrees ({}), blended over {:g} "
                    "degrees.",
                    mode_name(mode), mode.connection, mode.options.k_deg, mode.k_source,
                    mode.options.overlap_deg));
  }
  if (validation.has_distances) {
    page.add_paragraph("Distances of the corrected views: " + validation.distances + ".");
  }
  const auto limited =
      std::count_if(validation.views.begin(), validation.views.end(),
                    [](const ValidatedView& view) { return view.report.limited_corners > 0; });
  page.add_paragraph(
      fmt::format("In {} of {} views at least one corner connects nearer to the physical "
                  "connection than k requires, because the overhang of its lines runs out.",
                  limited, validation.views.size()));
  HtmlTable table{.caption =
                      "Shares of pixels: filled from other stations because the lines in "
                      "use do not see them, seen by no station, served by no line",
                  .header = {"view", "generation", "layers", "corners moved", "filled", "unseen",
                             "empty", "time / ms"}};
  for (const ValidatedView& view : validation.views) {
    const ViewReport& report = view.report;
    table.rows.push_back({{validation.truths[view.truth].name},
                          {mode_name(validation.modes[view.mode])},
                          {report.layers > 0 ? std::to_string(report.layers) : kNotMeasured},
                          {std::to_string(report.limited_corners)},
                          {percent(report.filled_share)},
                          {percent(report.stretched_share)},
                          {percent(report.empty_share)},
                          {number_or_dash(report.render_ms, 0)}});
  }
  page.add_table(table);
}

void add_views(const Validation& validation, HtmlPage& page) {
  page.add_section("Every view");
  for (const NamedScore& column : kNamedScores) add_view_table(validation, column, page);
  add_making(validation, page);
}

std::string subtitle_of(const Validation& validation) {
  if (validation.truths.empty()) return "connections of two rooms, without true views";
  return fmt::format("{} true viewpoints, each rendered {}", validation.truths.size(),
                     validation.modes.size() == 1
                         ? "as " + mode_name(validation.modes.front()) + " view"
                         : fmt::format("in {} ways", validation.modes.size()));
}

}  // namespace

std::string validation_report(const Validation& validation,
                              const std::optional<BeforeAfter>& compared) {
  const bool viewed = !validation.views.empty();
  HtmlPage page("Validation of " + validation.volume, subtitle_of(validation));
  if (viewed) {
    add_headline(validation, page);
    add_means(validation, page);
  }
  if (compared) add_before_after(*compared, &page);
  for (const PictureSample& sample : validation.samples) add_sample(validation, sample, page);
  if (viewed) add_gains(validation, page);
  add_connection_error(validation, page);
  if (viewed) add_views(validation, page);
  return page.html();
}

}  // namespace raywalk
