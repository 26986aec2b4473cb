#include "core/judge/trade/trade_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/judge/trade/captured_views.h"
#include "core/judge/trade/trade_plot.h"
#include "core/judge/validation/comparison_pictures.h"
#include "core/report/html_page.h"
#include "core/report/markup.h"
#include "core/report/svg_plot.h"

namespace raywalk {
namespace {

constexpr const char* kNotMeasured = "–";
constexpr const char* kFrontAnchor = "front";

// A measured quantity as a table column.
struct Column {
  const char* heading;  // with unit
  double (*value)(const TradeMeasurement&);
  int decimals;    // significant ones
  bool in_tables;  // else shown with the setting only
};

constexpr std::array kColumns{
    Column{"time / ms", [](const TradeMeasurement& m) { return m.time.ms; }, 2, true},
    Column{"time / remap", [](const TradeMeasurement& m) { return m.time.ratio; }, 2, true},
    Column{"CPU time / remap", [](const TradeMeasurement& m) { return m.time.cpu_ratio; }, 2,
           false},
    Column{"remap spread", [](const TradeMeasurement& m) { return m.time.remap_spread; }, 2, false},
    Column{"share of others", [](const TradeMeasurement& m) { return m.time.others_share; }, 2,
           false},
    Column{"PSNR / dB", [](const TradeMeasurement& m) { return m.scores.psnr_db; }, 2, true},
    Column{"WS-PSNR / dB", [](const TradeMeasurement& m) { return m.scores.ws_psnr_db; }, 2, true},
    Column{"SSIM", [](const TradeMeasurement& m) { return m.scores.ssim; }, 4, true},
    Column{"FSIM", [](const TradeMeasurement& m) { return m.scores.fsim; }, 4, true},
    Column{"E_connect", [](const TradeMeasurement& m) { return m.e_connect; }, 1, true},
    Column{"peak / MB", [](const TradeMeasurement& m) { return m.peak_mb; }, 1, true},
    Column{"mapped / MB", [](const TradeMeasurement& m) { return m.mapped_mb; }, 1, false},
    Column{"touched / MB",
           [](const TradeMeasurement& m) { return m.touched_mb.value_or(std::nan("")); }, 1,
           false}};

std::string title_of(const Trade& trade, std::size_t index) {
  return fmt::format("{} · {}", index + 1, marked_name(trade.settings[index]));
}

HtmlCell name_cell(const Trade& trade, std::size_t index) {
  return {.text = title_of(trade, index), .link = "#" + anchor_of(index)};
}

void add_headline(const Trade& trade, const std::vector<std::size_t>& front, HtmlPage* page) {
  const auto merit = [&](const char* name, std::size_t index) {
    const TradeMeasurement& measured = trade.settings[index].measured;
    return HtmlFact{
        fmt::format("{}: setting {}", name, index + 1),
        fmt::format("{:.2f} dB in {:.3g} ms", measured.scores.psnr_db, measured.time.ms)};
  };
  page->add_facts({merit("fastest", front.front()),
                   merit("most accurate", front.back()),
                   {"on the front", fmt::format("{} of {}", front.size(), trade.settings.size())},
                   {"one cv::remap of that size", fmt::format("{:.2f} ms", trade.remap_ms)}});
  if (const std::size_t count = disturbed_count(trade.settings); count > 0) {
    page->add_paragraph(fmt::format(
        "Other programs disturbed the times of {} of {} settings. These times, marked, are not to "
        "be relied on: {}, and --budget-ms and --min-psnr-db choose none of these settings. Run "
        "raywalk-render trade again while nothing else runs.",
        count, trade.settings.size(),
        count < trade.settings.size() ? "they are left out of the front"
                                      : "the front below may change"));
  }
  for (const TradedRoom& room : trade.rooms) {
    if (room.depth != kNoDepth) continue;
    page->add_paragraph(room.directory +
                        " has no distances, so that only initial views could be rendered from it; "
                        "raywalk-build-lf depth estimates them.");
  }
}

void add_front(const Trade& trade, const std::vector<std::size_t>& front, HtmlPage* page) {
  page->add_section("The front", kFrontAnchor);
  page->add_paragraph(
      "Each point is a setting of all parameters; click it for its parameters, scores and error "
      "picture. Filled and numbered: no other setting is both faster and more accurate. Up and to "
      "the left is better. Time is in units of one cv::remap of a panorama of the truths' size, "
      "run "
      "alternately with the views.");
  page->add_figures({svg_figure(trade_plot(trade), "")});
  HtmlTable table{.caption = "Settings on the front, the fastest first", .header = {"setting"}};
  for (const Column& column : kColumns) {
    if (column.in_tables) table.header.emplace_back(column.heading);
  }
  for (const std::size_t i : front) {
    std::vector<HtmlCell> row{name_cell(trade, i)};
    for (const Column& column : kColumns) {
      if (!column.in_tables) continue;
      row.push_back({number_or_dash(column.value(trade.settings[i].measured), column.decimals)});
    }
    table.rows.push_back(std::move(row));
  }
  page->add_table(table);
}

std::string percent_more(double value, double central) {
  return fmt::format("{:+.0f} %", 100.0 * (value / central - 1.0));
}

void add_presets(const Trade& trade, HtmlPage* page) {
  if (trade.presets.empty()) return;
  page->add_section("Presets");
  page->add_paragraph(
      "Settings derived from the room's own distances, spacing and width: --preset.");
  HtmlTable table{.header = {"preset", "setting", "time / ms", "time / remap", "PSNR / dB", "SSIM",
                             "slower than the front"}};
  for (const TradedPreset& preset : trade.presets) {
    const TradeMeasurement& measured = trade.settings[preset.setting].measured;
    // The fastest setting of at least the same PSNR.
    double least = measured.time.ratio;
    for (const MeasuredSetting& other : trade.settings) {
      if (other.measured.scores.psnr_db < measured.scores.psnr_db) continue;
      least = std::min(least, other.measured.time.ratio);
    }
    table.rows.push_back({{preset.name},
                          name_cell(trade, preset.setting),
                          {number_or_dash(measured.time.ms, 2)},
                          {number_or_dash(measured.time.ratio, 2)},
                          {number_or_dash(measured.scores.psnr_db, 2)},
                          {number_or_dash(measured.scores.ssim, 4)},
                          {percent_more(measured.time.ratio, least)}});
  }
  page->add_table(table);
  for (const TradedPreset& preset : trade.presets) {
    page->add_paragraph(preset.name + ": " + preset.reason + ".");
  }
}

void add_held_out(const Trade& trade, HtmlPage* page) {
  if (trade.held_out_views.empty()) return;
  const RankAgreement agreement = rank_agreement(trade.settings);
  page->add_section("Held-out stations against the truth");
  page->add_paragraph(
      "The same settings scored without captured truth: stations of the room are left out and "
      "rendered from the others. Where the order of the settings is the same, the stations of a "
      "room can replace true views.");
  page->add_facts({{"rank correlation, PSNR", number_or_dash(agreement.psnr_db, 3)},
                   {"WS-PSNR", number_or_dash(agreement.ws_psnr_db, 3)},
                   {"SSIM", number_or_dash(agreement.ssim, 3)},
                   {"FSIM", number_or_dash(agreement.fsim, 3)}});
  LinePlot plot{.title = "Each point is a setting",
                .x_label = "PSNR against the truth, dB",
                .y_label = "PSNR of held-out stations, dB"};
  PlotSeries series{.style = PlotStyle::kPoints};
  for (std::size_t i = 0; i < trade.settings.size(); ++i) {
    const TradeMeasurement& measured = trade.settings[i].measured;
    series.points.push_back({measured.scores.psnr_db, measured.held_out.value().psnr_db});
    series.marks.push_back({.link = "#" + anchor_of(i), .title = trade.settings[i].setting.name});
  }
  plot.series.push_back(std::move(series));
  page->add_figures({svg_figure(svg_from_plot(plot), "")});
}

// A score's gain over the central setting's.
std::string difference(double value, double central, int decimals) {
  const double gain = value - central;
  return std::isfinite(gain) ? fmt::format("{:+.{}f}", gain, decimals) : kNotMeasured;
}

// Whether a column is shown as a difference; times are shown as a ratio instead.
bool differs(const Column& column) {
  return column.in_tables && !std::string_view(column.heading).starts_with("time");
}

std::vector<HtmlCell> moved_row(const Trade& trade, std::size_t index, std::size_t centre) {
  const TradeMeasurement& measured = trade.settings[index].measured;
  const TradeMeasurement& central = trade.settings[centre].measured;
  std::vector<HtmlCell> row{name_cell(trade, index),
                            {number_or_dash(measured.time.ms, 2)},
                            {percent_more(measured.time.ratio, central.time.ratio)},
                            {percent_more(measured.time.cpu_ratio, central.time.cpu_ratio)}};
  for (const Column& column : kColumns) {
    if (!differs(column)) continue;
    row.push_back({difference(column.value(measured), column.value(central), column.decimals)});
  }
  return row;
}

// Number of changed parameters; another room counts as one, though it changes two.
std::size_t changed_parameter_count(const TradeSetting& setting, const TradeSetting& centre) {
  std::size_t parameters = setting.room == centre.room ? 0 : 1;
  for (const std::string& parameter : changed_parameters(setting, centre)) {
    if (parameter != "stored_width_px" && parameter != "depth") ++parameters;
  }
  return parameters;
}

void add_single_parameters(const Trade& trade, HtmlPage* page) {
  page->add_section("One parameter at a time");
  page->add_paragraph(
      "The effect of each parameter alone: time and scores relative to the central setting of its "
      "generation, which is the default.");
  for (std::size_t centre = 0; centre < trade.settings.size(); ++centre) {
    const TradeSetting& central = trade.settings[centre].setting;
    // The name of a central setting is its generation's alone.
    const std::string generation = generation_name(central.mode.options.generation);
    if (central.name != generation) continue;
    HtmlTable table{.caption = "Against " + generation,
                    .header = {"setting", "time / ms", "time", "CPU time"}};
    for (const Column& column : kColumns) {
      if (differs(column)) table.header.emplace_back(column.heading);
    }
    for (std::size_t i = 0; i < trade.settings.size(); ++i) {
      const TradeSetting& setting = trade.settings[i].setting;
      const bool same = setting.mode.options.generation == central.mode.options.generation;
      if (same && changed_parameter_count(setting, central) == 1)
        table.rows.push_back(moved_row(trade, i, centre));
    }
    if (!table.rows.empty()) page->add_table(table);
  }
}

HtmlCard card_of(const Trade& trade, std::size_t index, const TradePictures& pictures) {
  const MeasuredSetting& setting = trade.settings[index];
  HtmlCard card{.anchor = anchor_of(index),
                .heading = title_of(trade, index),
                .back = {.file = std::string("#") + kFrontAnchor, .text = "front"}};
  if (!pictures.errors[index].empty()) {
    card.picture = picture_figure(pictures.errors[index], EmbeddedFormat::kJpeg,
                                  "Error of " + setting.setting.name + " at " + pictures.view, "")
                       .markup;
  }
  card.facts.resize(2);
  const nlohmann::ordered_json parameters = parameters_of(setting.setting);
  for (const auto& [parameter, value] : parameters.items()) {
    card.facts[0].push_back({parameter, parameter_text(value)});
  }
  for (const Column& column : kColumns) {
    card.facts[1].push_back(
        {column.heading, number_or_dash(column.value(setting.measured), column.decimals)});
  }
  return card;
}

void add_settings(const Trade& trade, const TradePictures& pictures, HtmlPage* page) {
  page->add_section("Every setting");
  const bool all_shown =
      std::ranges::none_of(pictures.errors, [](const cv::Mat& picture) { return picture.empty(); });
  page->add_paragraph(fmt::format(
      "With the error at {}, times {:g}{}. Parameters are named as in the settings file "
      "configs/view.yaml.",
      pictures.view, kErrorGain, all_shown ? "" : ", of settings on the front and near it"));
  page->add_figures(
      {picture_figure(pictures.truth, EmbeddedFormat::kJpeg, "Ground truth at " + pictures.view,
                      "Ground truth at " + pictures.view)});
  std::vector<HtmlCard> cards;
  for (std::size_t i = 0; i < trade.settings.size(); ++i) {
    cards.push_back(card_of(trade, i, pictures));
  }
  page->add_cards(cards);
}

void add_dials(HtmlPage* page) {
  page->add_section("What the parameters are, and their cost per output pixel");
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    page->add_paragraph(fmt::format("{}: {}. {}; default {}. Cost: {}.", dial.key, dial.help,
                                    values_text(dial), text_of(dial, default_of(dial)), dial.cost));
  }
}

void add_making(const Trade& trade, HtmlPage* page) {
  page->add_section("How it was measured");
  page->add_paragraph(fmt::format(
      "Times are medians over {} views, each rendered {} times after a warm-up. Scores are means "
      "over the views; a picture smaller than its truth is enlarged before it is scored, and its "
      "time does not include that. Views: {}.",
      trade.views.size(), trade.repetitions, fmt::join(trade.views, ", ")));
  page->add_paragraph(
      "Peak: growth of the resident set by one view of a newly opened room; mapped: the part of it "
      "that is pages of the room's files, which the system can reclaim. Touched: bytes of the "
      "volumes that one view reads. CPU time is that of all threads, which other programs disturb "
      "less. A time counts as disturbed where a quarter of the remaps beside it took a quarter "
      "longer than the fastest (remap spread above 0.25), where they took a quarter longer than in "
      "the rest of the trade, or where other programs used more than a twentieth of the processors "
      "(share of others); such settings were timed again before they were marked.");
  page->add_paragraph(fmt::format(
      "E_connect is measured once for each generation and k, over {0} x {0} viewpoints of every "
      "cell, in squared 8-bit levels, over the corners that are readable at every k of the sweep; "
      "a "
      "dash where these are less than half of all.",
      trade.connect_viewpoints));
  for (const TradedRoom& room : trade.rooms) {
    page->add_paragraph(fmt::format("{}: stored {} pixels wide, distances: {}.", room.directory,
                                    room.stored_width_px, room.depth));
  }
}

}  // namespace

std::string trade_page(const Trade& trade, const TradePictures& pictures) {
  HtmlPage page("Speed and accuracy of " + trade.rooms.front().directory,
                fmt::format("{} settings, {} true viewpoints, {} x {} pixels, {} threads of {}",
                            trade.settings.size(), trade.views.size(), trade.width_px,
                            trade.width_px / 2, trade.threads, trade.cpu));
  const std::vector<std::size_t> front = psnr_front(trade);
  add_headline(trade, front, &page);
  add_front(trade, front, &page);
  add_presets(trade, &page);
  add_held_out(trade, &page);
  add_single_parameters(trade, &page);
  add_settings(trade, pictures, &page);
  add_dials(&page);
  add_making(trade, &page);
  return page.html();
}

}  // namespace raywalk
