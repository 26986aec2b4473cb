#include "build_lf/depth/depth_summary.h"

#include <nlohmann/json.hpp>

namespace raywalk::build_lf {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const TruthComparison& truth) {
  ordered_json bands = ordered_json::array();
  for (const ConfidenceBand& band : truth.calibration) {
    bands.push_back({{"confidence", band.confidence},
                     {"pixels", band.pixels},
                     {"wrong_share", band.wrong_share},
                     {"median_error_px", band.median_error_px}});
  }
  return {{"maps", truth.maps},
          {"within_1px_share", truth.within_1px_share},
          {"within_2px_share", truth.within_2px_share},
          {"within_4px_share", truth.within_4px_share},
          {"median_relative_error", truth.median_relative_error},
          {"calibration", std::move(bands)}};
}

ordered_json json_of(const FrameFinding& finding) {
  return {{"file", finding.file}, {"fault", name_of(finding.fault)}, {"measure", finding.measure}};
}

ordered_json json_of(const MapSummary& map) {
  return {{"line", map.line},           {"station", map.station},
          {"file", map.file},           {"mean_confidence", map.mean_confidence},
          {"low_share", map.low_share}, {"parallax_share", map.parallax_share}};
}

}  // namespace

std::string depth_summary_to_json(const DepthSummary& summary) {
  ordered_json json{{"format", "raywalk-depth"},
                    {"format_version", 1},
                    {"room", summary.room},
                    {"method", summary.method},
                    {"width", summary.size.width},
                    {"height", summary.size.height},
                    {"stations", summary.stations},
                    {"every", summary.every},
                    {"hold_out", summary.hold_out},
                    {"valid_mask", summary.valid_mask},
                    {"reach_m", summary.reach_m},
                    {"nearest_m", summary.nearest_m},
                    {"layers", summary.layers},
                    {"gain_spread", summary.gain_spread},
                    {"largest_exposure_step", summary.largest_exposure_step},
                    {"seconds", summary.seconds},
                    {"peak_memory_mb", summary.peak_memory_mb},
                    {"warnings", summary.warnings}};
  json["frame_findings"] = ordered_json::array();
  for (const FrameFinding& finding : summary.frame_findings) {
    json["frame_findings"].push_back(json_of(finding));
  }
  json["truth"] = summary.truth ? json_of(*summary.truth) : ordered_json(nullptr);
  json["maps"] = ordered_json::array();
  for (const MapSummary& map : summary.maps) json["maps"].push_back(json_of(map));
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace raywalk::build_lf
