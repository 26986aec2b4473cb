#include "core/judge/trade/trade_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/judge/trade/trade_plot.h"
#include "core/judge/validation/comparison_pictures.h"
#include "core/report/json_page.h"
#include "core/view/view_options.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFrontAnchor = "front";
constexpr const char* kTitle = "{number} · {name}{disturbed: (time disturbed)|}";
constexpr const char* kAnchor = "setting-{number}";
constexpr const char* kLink = "#setting-{number}";

void add_headline(JsonPage page) {
  const JsonPage best = page.parts("front").back();
  page.facts(
      {{"fastest: setting {front.0.number}", "{front.0.psnr_db:.2f dB} in {front.0.ms:.3g ms}"},
       {best.text("most accurate: setting {number}"), best.text("{psnr_db:.2f dB} in {ms:.3g ms}")},
       {"on the front", "{front:size} of {settings:size}"},
       {"one cv::remap of that size", "{remap_ms:.2f ms}"}});
  page.when("disturbed_settings")
      .paragraph(
          "Other programs disturbed the times of {disturbed_settings} of {settings:size} settings. "
          "These times, marked, are not to be relied on: {front.0.disturbed:the front below may "
          "change|they are left out of the front}, and --budget-ms and --min-psnr-db choose none "
          "of these settings. Run raywalk-render trade again while nothing else runs.");
  for (JsonPage& room : page.parts("rooms")) {
    room.when("depth is none")
        .paragraph(
            "{directory} has no distances, so that only initial views could be rendered from it; "
            "raywalk-build-lf depth estimates them.");
  }
}

void add_front(const HtmlFigure& plot, JsonPage page) {
  page.section("The front", kFrontAnchor)
      .paragraph(
          "Each point is a setting of all parameters; click it for its parameters, scores and "
          "error picture. Filled and numbered: no other setting is both faster and more accurate. "
          "Up and to the left is better. Time is in units of one cv::remap of a panorama of the "
          "truths' size, run alternately with the views.")
      .figures({plot})
      .table("front",
             {{"setting", kTitle, "", kLink},
              {"time / ms", "{ms:.2f}"},
              {"time / remap", "{ratio:.2f}"},
              {"PSNR / dB", "{psnr_db:.2f}"},
              {"WS-PSNR / dB", "{ws_psnr_db:.2f}"},
              {"SSIM", "{ssim:.4f}"},
              {"FSIM", "{fsim:.4f}"},
              {"E_connect", "{e_connect:.1f}"},
              {"peak / MB", "{peak_mb:.1f}"},
              {"panoramas on disk / MB", "{rays_mb:.1f}"}},
             "Settings on the front, the fastest first");
}

void add_presets(JsonPage page) {
  page.section("Presets")
      .paragraph("Settings derived from the room's own distances, spacing and width: --preset.")
      .table("presets",
             {{"preset", "{name}"},
              {"setting", "{number} · {setting}{disturbed: (time disturbed)|}", "", kLink},
              {"time / ms", "{ms:.2f}"},
              {"time / remap", "{ratio:.2f}"},
              {"PSNR / dB", "{psnr_db:.2f}"},
              {"SSIM", "{ssim:.4f}"},
              {"slower than the front", "{slower_than_front:+.0%}"}})
      .paragraphs("presets", "{name}: {reason}.");
}

void add_held_out(const ordered_json& document, JsonPage page) {
  if (document["rank_correlation"].is_null()) return;
  page.section("Held-out stations against the truth")
      .paragraph(
          "The same settings scored without captured truth: stations of the room are left out and "
          "rendered from the others. Where the order of the settings is the same, the stations of "
          "a room can replace true views.")
      .facts({{"rank correlation, PSNR", "{rank_correlation.psnr_db:.3f}"},
              {"WS-PSNR", "{rank_correlation.ws_psnr_db:.3f}"},
              {"SSIM", "{rank_correlation.ssim:.3f}"},
              {"FSIM", "{rank_correlation.fsim:.3f}"}})
      .figures({held_out_plot(document)});
}

void add_single_parameters(JsonPage page) {
  page.section("One parameter at a time")
      .paragraph(
          "The effect of each parameter alone: time and scores relative to the central setting of "
          "its generation, which is the default.");
  for (JsonPage& centre : page.parts("single_parameters")) {
    centre.table("changes",
                 {{"setting", kTitle, "", kLink},
                  {"time / ms", "{ms:.2f}"},
                  {"time", "{ratio:+.0%}"},
                  {"CPU time", "{cpu_ratio:+.0%}"},
                  {"PSNR / dB", "{psnr_db:+.2f}"},
                  {"WS-PSNR / dB", "{ws_psnr_db:+.2f}"},
                  {"SSIM", "{ssim:+.4f}"},
                  {"FSIM", "{fsim:+.4f}"},
                  {"E_connect", "{e_connect:+.1f}"},
                  {"peak / MB", "{peak_mb:+.1f}"},
                  {"panoramas on disk / MB", "{rays_mb:+.1f}"}},
                 "Against {generation}");
  }
}

std::vector<HtmlFact> parameter_facts() {
  std::vector<HtmlFact> facts;
  for (const Dial& dial : kDials) {
    const char* format = dial.value.kind == DialKind::kNumber ? ":g" : "";
    if (dial.sweep) facts.push_back({dial.key, fmt::format("{{{}{}}}", dial.key, format)});
  }
  for (const char* key : {"threads", "stored_width_px", "depth", "compression"}) {
    facts.push_back({key, fmt::format("{{{}}}", key)});
  }
  return facts;
}

void add_settings(const TradePictures& pictures, JsonPage page) {
  std::vector<std::string> errors;
  for (const JsonPage& setting : page.parts("settings")) {
    const cv::Mat& error = pictures.errors[errors.size()];
    const std::string of = setting.text("Error of {name} at {/pictured_view}");
    errors.push_back(error.empty() ? ""
                                   : picture_figure(error, EmbeddedFormat::kJpeg, of, "").markup);
  }
  const bool all_shown = std::ranges::count(errors, "") == 0;
  const std::string truth = page.text("Ground truth at {pictured_view}");
  page.section("Every setting")
      .paragraph(fmt::format("With the error at {{pictured_view}}, times {:g}{}. Parameters are "
                             "named as in the settings file configs/view.yaml.",
                             kErrorGain, all_shown ? "" : ", of settings on the front and near it"))
      .figures({picture_figure(pictures.truth, EmbeddedFormat::kJpeg, truth, truth)})
      .cards("settings",
             {.anchor = kAnchor,
              .heading = kTitle,
              .back = {.target = std::string("#") + kFrontAnchor, .text = "front"},
              .facts = {parameter_facts(),
                        {{"time / ms", "{ms:.2f}"},
                         {"time / remap", "{ratio:.2f}"},
                         {"CPU time / remap", "{cpu_ratio:.2f}"},
                         {"remap spread", "{remap_spread:.2f}"},
                         {"share of others", "{others_share:.2f}"},
                         {"PSNR / dB", "{psnr_db:.2f}"},
                         {"WS-PSNR / dB", "{ws_psnr_db:.2f}"},
                         {"SSIM", "{ssim:.4f}"},
                         {"FSIM", "{fsim:.4f}"},
                         {"E_connect", "{e_connect:.1f}"},
                         {"peak / MB", "{peak_mb:.1f}"},
                         {"panoramas on disk / MB", "{rays_mb:.1f}"},
                         {"mapped / MB", "{mapped_mb:.1f}"}}}},
             errors);
}

void add_making(JsonPage page) {
  page.section("What the parameters are, and their cost per output pixel")
      .paragraphs("parameters", "{key}: {help}. {values}; default {default}. Cost: {cost}.");
  page.section("How it was measured")
      .paragraph(
          "Times are medians over {views:counted view}, each rendered {repetitions} times after a "
          "warm-up. Scores are means over the views; a picture smaller than its truth is enlarged "
          "before it is scored, and its time does not include that. Views: {views:joined}.")
      .paragraph(
          "Peak: growth of the resident set by one view of a newly opened room; mapped: the part "
          "of it that is pages of the room's files, which the system can reclaim. Times "
          "are of views whose panoramas are decoded where the room is compressed; decoded "
          "panoramas count in peak, not in mapped. CPU time is that of all threads, which other "
          "programs disturb less. A time counts as disturbed where a quarter of the remaps beside "
          "it took a quarter longer than the fastest (remap spread above 0.25), where they took a "
          "quarter longer than in the rest of the trade, or where other programs used more than a "
          "twentieth of the processors (share of others); such settings were timed again before "
          "they were marked.")
      .paragraph(
          "E_connect is measured once for each generation and k, over {connect_viewpoints} x "
          "{connect_viewpoints} viewpoints of every cell, in squared 8-bit levels, over the "
          "corners that are readable at every k of the sweep; a dash where these are less than "
          "half of all.")
      .paragraphs(
          "rooms",
          "{directory}: stored {stored_width_px} pixels wide, distances: {depth}; panoramas: "
          "compression {compression}, {rays_mb:.1f} MB.");
}

}  // namespace

std::string trade_page(const ordered_json& document, const TradePictures& pictures) {
  JsonPage page(document, "Speed and accuracy of {room}",
                "{settings:counted setting}, {views:counted true viewpoint}, {width_px} pixels "
                "wide, {machine.threads:counted thread} of {machine.cpu}");
  add_headline(page);
  add_front(trade_plot(document), page);
  add_presets(page.when("presets"));
  add_held_out(document, page);
  add_single_parameters(page);
  add_settings(pictures, page);
  add_making(page);
  return page.html();
}

}  // namespace raywalk
