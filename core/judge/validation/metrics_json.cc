#include "core/judge/validation/metrics_json.h"

#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const ViewScores& scores) {
  ordered_json json;
  for (const NamedScore& score : kNamedScores) json[score.key] = scores.*score.member;
  return json;
}

ordered_json json_of(const Validation& validation, const ValidatedView& view) {
  const TruthView& truth = validation.truths[view.truth];
  const ViewMode& mode = validation.modes[view.mode];
  ordered_json json = {{"name", truth.name},
                       {"x_m", truth.viewpoint.x_m},
                       {"z_m", truth.viewpoint.z_m},
                       {"generation", generation_name(mode.options.generation)},
                       {"connection", mode.connection},
                       {"k_deg", mode.options.k_deg},
                       {"layers", view.report.layers},
                       {"enlargement", enlargement_at(validation, truth.width)}};
  json.update(json_of(view.scores));
  json["render_ms"] = view.report.render_ms;
  return json;
}

// NaN (not measurable) becomes null when the text is written.
ordered_json json_of(const ConnectErrorRow& row, double common_share) {
  return {{"connection", row.connection},
          {"k_deg", row.k_deg},
          {"generation", generation_name(row.generation)},
          {"e_connect", row.e_connect},
          {"e_connect_common", row.e_connect_common},
          {"coverage", row.coverage},
          {"common_share", common_share}};
}

}  // namespace

std::string metrics_json(const Validation& validation, const std::optional<BeforeAfter>& compared) {
  ordered_json json;
  json["volume"] = validation.volume;
  json["distances"] = validation.distances;
  json["views"] = ordered_json::array();
  for (const ValidatedView& view : validation.views) {
    json["views"].push_back(json_of(validation, view));
  }
  json["connection_error"] = ordered_json::array();
  for (const ConnectError& measured : validation.connection_error) {
    for (const ConnectErrorRow& row : measured.rows) {
      json["connection_error"].push_back(json_of(row, measured.common_share));
    }
  }
  json["means"] = ordered_json::object();
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.views.empty()) break;
    const std::string name = generation_name(validation.modes[mode].options.generation);
    json["means"][name] = json_of(mean_scores(validation, mode));
  }
  if (compared) json["before_after"] = before_after_json(*compared);
  // A room's name may contain any bytes; invalid UTF-8 is replaced.
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace raywalk
