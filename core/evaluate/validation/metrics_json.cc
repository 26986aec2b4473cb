#include "core/evaluate/validation/metrics_json.h"

#include <nlohmann/json.hpp>

#include "core/base/median.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

std::string generation_of(const ViewMode& mode) { return generation_name(mode.options.generation); }

ordered_json json_of(const ViewScores& scores) {
  return {{"psnr_db", scores.psnr_db},
          {"ws_psnr_db", scores.ws_psnr_db},
          {"ssim", scores.ssim},
          {"fsim", scores.fsim}};
}

// NaN (not measured) becomes null when the text is written.
ordered_json json_of(const SilhouetteScores& scores) {
  return {{"psnr_near_silhouettes_db", scores.near_psnr_db},
          {"psnr_elsewhere_db", scores.elsewhere_psnr_db},
          {"near_silhouettes_share", scores.near_share},
          {"specks_per_megapixel", scores.specks_per_mpx}};
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
  json.update({{"limited_corners", view.report.limited_corners},
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
  json.update(json_of(mean_scores(validation, index)));
  if (measures_silhouettes(validation)) json.update(json_of(mean_silhouettes(validation, index)));
  json["median_render_ms"] = median(times_ms);
  return json;
}

ordered_json quarters_json(const Validation& validation) {
  ordered_json json = ordered_json::array();
  for (const ValidatedView& view : validation.views) {
    for (const QuarterScore& score : view.quarters) {
      json.push_back({{"name", validation.truths[view.truth].name},
                      {"generation", generation_of(validation.modes[view.mode])},
                      {"line_distance_m", score.line_distance_m},
                      {"psnr_db", score.psnr_db},
                      {"ssim", score.ssim},
                      {"fsim", score.fsim}});
    }
  }
  return json;
}

// NaN (not measurable) becomes null when the text is written.
ordered_json json_of(const ConnectErrorRow& row) {
  return {{"connection", row.connection},
          {"k_deg", row.k_deg},
          {"generation", generation_name(row.generation)},
          {"e_connect", row.e_connect},
          {"e_connect_common", row.e_connect_common},
          {"coverage", row.coverage}};
}

}  // namespace

ordered_json metrics_document(const Validation& validation) {
  ordered_json json{{"volume", validation.volume},
                    {"distances", validation.distances},
                    {"captured_width_px", validation.captured_width_px},
                    {"truths", validation.truths.size()},
                    {"widest_truth_px", widest_truth_px(validation)},
                    {"modes", ordered_json::array()},
                    {"views", ordered_json::array()},
                    {"quarters", quarters_json(validation)},
                    {"connection", nullptr},
                    {"connection_error", ordered_json::array()}};
  for (const ValidatedView& view : validation.views) {
    json["views"].push_back(json_of(validation, view));
  }
  for (std::size_t mode = 0; mode < validation.modes.size() && !validation.views.empty(); ++mode) {
    json["modes"].push_back(mode_json(validation, mode));
  }
  for (const ConnectError& measured : validation.connection_error) {
    for (const ConnectErrorRow& row : measured.rows) {
      json["connection_error"].push_back(json_of(row));
    }
  }
  if (!validation.connection_error.empty()) {
    const ConnectError& first = validation.connection_error.front();
    json["connection"] = {{"viewpoints", first.options.viewpoints},
                          {"overlap_deg", first.options.overlap_deg},
                          {"common_share", first.common_share},
                          {"comparable", first.common_share >= kLeastCommonShare}};
  }
  return json;
}

}  // namespace raywalk
