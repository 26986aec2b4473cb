#include "core/judge/validation/metrics_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "core/base/median.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

std::string generation_of(const ViewMode& mode) { return generation_name(mode.options.generation); }

// The views of one truth, mode by mode.
std::span<const ValidatedView> views_of(const Validation& validation, std::size_t truth) {
  const std::size_t modes = validation.modes.size();
  return std::span(validation.views).subspan(truth * modes, modes);
}

ordered_json json_of(const ViewScores& scores) {
  ordered_json json;
  for (const NamedScore& score : kNamedScores) json[score.key] = scores.*score.member;
  return json;
}

// NaN (not measured) becomes null when the text is written.
ordered_json json_of(const SilhouetteScores& scores) {
  return {{"psnr_near_silhouettes_db", scores.near_psnr_db},
          {"psnr_elsewhere_db", scores.elsewhere_psnr_db},
          {"near_silhouettes_share", scores.near_share},
          {"specks_per_megapixel", scores.specks_per_mpx}};
}

ordered_json means_json(const Validation& validation, std::size_t mode) {
  ordered_json json = json_of(mean_scores(validation, mode));
  if (measures_silhouettes(validation)) json.update(json_of(mean_silhouettes(validation, mode)));
  return json;
}

// Of each score whether no other mode has a better one of this truth.
ordered_json best_json(const Validation& validation, const ValidatedView& view) {
  const std::span<const ValidatedView> all = views_of(validation, view.truth);
  ordered_json json;
  for (const NamedScore& score : kNamedScores) {
    json[score.key] = all.size() > 1 && std::ranges::none_of(all, [&](const ValidatedView& other) {
                        return other.scores.*score.member > view.scores.*score.member;
                      });
  }
  return json;
}

ordered_json json_of(const Validation& validation, const ValidatedView& view) {
  const TruthView& truth = validation.truths[view.truth];
  const ViewMode& mode = validation.modes[view.mode];
  ordered_json json = {{"name", truth.name},
                       {"x_m", truth.viewpoint.x_m},
                       {"z_m", truth.viewpoint.z_m},
                       {"line_distance_m", truth.line_distance_m},
                       {"generation", generation_of(mode)},
                       {"connection", mode.connection},
                       {"k_deg", mode.options.k_deg},
                       {"enlargement", enlargement_at(validation, truth.width)}};
  if (truth.height_m && mode.options.generation != Generation::kInitial) {
    json["y_m"] = *truth.height_m;
  }
  json.update(json_of(view.scores));
  if (measures_silhouettes(validation)) json.update(json_of(view.silhouettes));
  json.update({{"best", best_json(validation, view)},
               {"limited_corners", view.report.limited_corners},
               {"filled_share", view.report.filled_share},
               {"unseen_share", view.report.unseen_share},
               {"empty_share", view.report.empty_share},
               {"render_ms", view.report.render_ms}});
  return json;
}

ordered_json mode_json(const Validation& validation, std::size_t index) {
  const ViewMode& mode = validation.modes[index];
  std::vector<double> times_ms;
  for (const ValidatedView& view : validation.views) {
    if (view.mode == index) times_ms.push_back(view.report.render_ms);
  }
  ordered_json json{{"generation", generation_of(mode)},
                    {"connection", mode.connection},
                    {"k_deg", mode.options.k_deg},
                    {"k_source", mode.k_source},
                    {"overlap_deg", mode.options.overlap_deg}};
  json.update(means_json(validation, index));
  json["median_render_ms"] = median(times_ms);
  return json;
}

// The mode with the largest mean PSNR and its gain over initial views; null gain without these.
ordered_json best_mode_json(const ordered_json& modes) {
  ordered_json best = *std::ranges::max_element(
      modes, {}, [](const ordered_json& mode) { return mode["psnr_db"].get<double>(); });
  best["gain_db"] = nullptr;
  if (best["generation"] == "initial") return best;
  for (const ordered_json& mode : modes) {
    if (mode["generation"] != "initial") continue;
    best["gain_db"] = best["psnr_db"].get<double>() - mode["psnr_db"].get<double>();
  }
  return best;
}

std::optional<std::size_t> initial_mode(const Validation& validation) {
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.modes[mode].options.generation == Generation::kInitial) return mode;
  }
  return std::nullopt;
}

// The scores of every quarter; if a mode is given, their gain over its.
ordered_json quarters_json(const Validation& validation, std::optional<std::size_t> over) {
  ordered_json json = ordered_json::array();
  for (const ValidatedView& view : validation.views) {
    for (std::size_t i = 0; i < view.quarters.size(); ++i) {
      const QuarterScore& score = view.quarters[i];
      const QuarterScore zero =
          over ? views_of(validation, view.truth)[*over].quarters[i] : QuarterScore{};
      json.push_back({{"name", validation.truths[view.truth].name},
                      {"generation", generation_of(validation.modes[view.mode])},
                      {"line_distance_m", score.line_distance_m},
                      {"psnr_db", score.psnr_db - zero.psnr_db},
                      {"ssim", score.ssim - zero.ssim},
                      {"fsim", score.fsim - zero.fsim}});
    }
  }
  return json;
}

bool is_comparable(const ConnectError& measured) {
  return measured.common_share >= kLeastCommonShare;
}

// NaN (not measurable) becomes null when the text is written.
ordered_json json_of(const ConnectErrorRow& row, const ConnectError& measured) {
  const bool comparable = is_comparable(measured);
  const bool least = comparable && std::isfinite(row.e_connect_common) &&
                     std::ranges::none_of(measured.rows, [&](const ConnectErrorRow& other) {
                       return other.e_connect_common < row.e_connect_common;
                     });
  return {{"connection", row.connection},
          {"k_deg", row.k_deg},
          {"generation", generation_name(row.generation)},
          {"e_connect", row.e_connect},
          {"e_connect_common", row.e_connect_common},
          {"coverage", row.coverage},
          {"common_share", measured.common_share},
          {"least", least},
          {"e_connect_plotted", comparable ? row.e_connect_common : row.e_connect}};
}

// The largest plotted error of corrected views; null unless initial views were measured too.
ordered_json corrected_up_to(const ordered_json& rows) {
  double largest = std::nan("");
  bool has_initial = false;
  for (const ordered_json& row : rows) {
    if (row["generation"] == "initial") {
      has_initial = true;
    } else {
      largest = std::fmax(largest, row["e_connect_plotted"].get<double>());
    }
  }
  return has_initial && largest > 0.0 ? ordered_json(largest) : nullptr;
}

void add_connection_error(const Validation& validation, ordered_json* json) {
  ordered_json rows = ordered_json::array();
  for (const ConnectError& measured : validation.connection_error) {
    for (const ConnectErrorRow& row : measured.rows) rows.push_back(json_of(row, measured));
  }
  (*json)["connection"] = nullptr;
  if (!rows.empty()) {
    const ConnectError& first = validation.connection_error.front();
    (*json)["connection"] = {{"viewpoints", first.options.viewpoints},
                             {"overlap_deg", first.options.overlap_deg},
                             {"common_share", first.common_share},
                             {"comparable", is_comparable(first)},
                             {"corrected_up_to", corrected_up_to(rows)}};
  }
  (*json)["connection_error"] = std::move(rows);
}

}  // namespace

ordered_json metrics_document(const Validation& validation,
                              const std::optional<BeforeAfter>& compared) {
  const auto limited = std::ranges::count_if(
      validation.views, [](const ValidatedView& view) { return view.report.limited_corners > 0; });
  ordered_json json{{"volume", validation.volume},
                    {"distances", validation.distances},
                    {"captured_width_px", validation.captured_width_px},
                    {"truths", validation.truths.size()},
                    {"widest_truth_px", widest_truth_px(validation)},
                    {"modes", ordered_json::array()},
                    {"best", nullptr},
                    {"views", ordered_json::array()},
                    {"limited_views", limited},
                    {"quarters", quarters_json(validation, std::nullopt)},
                    {"quarter_gains", ordered_json::array()},
                    {"means", ordered_json::object()}};
  for (const ValidatedView& view : validation.views) {
    json["views"].push_back(json_of(validation, view));
  }
  if (!validation.views.empty()) {
    for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
      json["modes"].push_back(mode_json(validation, mode));
      json["means"][generation_of(validation.modes[mode])] = means_json(validation, mode);
    }
    json["best"] = best_mode_json(json["modes"]);
    const auto initial = initial_mode(validation);
    if (initial && validation.modes.size() > 1) {
      json["quarter_gains"] = quarters_json(validation, initial);
    }
  }
  add_connection_error(validation, &json);
  if (compared) json["before_after"] = before_after_json(*compared);
  return json;
}

}  // namespace raywalk
