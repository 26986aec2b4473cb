#include "build_lf/depth/depth_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/base/parallel.h"
#include "core/room/distance_volume.h"

namespace raywalk::build_lf {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const std::vector<ConfidenceBand>& bands) {
  ordered_json json = ordered_json::array();
  for (const ConfidenceBand& band : bands) {
    json.push_back({{"confidence", band.confidence},
                    {"pixels", band.pixels},
                    {"wrong_share", band.wrong_share},
                    {"median_error_px", band.median_error_px}});
  }
  return json;
}

ordered_json json_of(const TruthComparison& truth) {
  return {{"maps", truth.maps},
          {"within_1px_share", truth.within_1px_share},
          {"within_2px_share", truth.within_2px_share},
          {"within_4px_share", truth.within_4px_share},
          {"median_relative_error", truth.median_relative_error},
          {"summary", text_of(truth)},
          {"elsewhere", json_of(truth.elsewhere)},
          {"edges", json_of(truth.edges)}};
}

ordered_json json_of(const GainsSummary& gains) {
  return {{"stations", gains.stations}, {"corrected", gains.corrected},
          {"local", gains.local},       {"spread", gains.spread},
          {"largest", gains.largest},   {"summary", text_of(gains)}};
}

ordered_json json_of(const FrameFinding& finding) {
  return {{"file", finding.file}, {"fault", name_of(finding.fault)}, {"measure", finding.measure}};
}

ordered_json json_of(const std::vector<LeftOutSummary>& stations) {
  ordered_json json = ordered_json::array();
  for (const LeftOutSummary& station : stations) {
    json.push_back({{"line", station.line},
                    {"station", station.station},
                    {"file", station.file},
                    {"share", station.share}});
  }
  return json;
}

ordered_json json_of(const MapSummary& map) {
  return {{"line", map.line},           {"station", map.station},
          {"file", map.file},           {"mean_confidence", map.mean_confidence},
          {"low_share", map.low_share}, {"parallax_share", map.parallax_share}};
}

// What the run changed for views.
std::string use_text(const DepthSummary& summary) {
  if (summary.hold_out > 0) {
    return fmt::format(
        "for raywalk-render trade --held-out {}; distances in use by views, as before: {}",
        summary.hold_out, summary.distances);
  }
  std::string use = "views now use the distances " + summary.distances;
  if (summary.kept_given.empty()) return use;
  return fmt::format(
      "{}; the given ones are kept in {}, `raywalk-build-lf distances {} --use "
      "given` goes back to them",
      use, summary.kept_given, shell_word(summary.room));
}

MapSummary map_summary(const InverseDistanceMap& map, const Line& line,
                       double pixels_per_inverse_m) {
  MapSummary summary{line.id, map.station.station,
                     line.stations[static_cast<size_t>(map.station.station)].file};
  double total = 0.0;
  for (size_t p = 0; p < map.confidence.size(); ++p) {
    const double row = static_cast<double>(p % static_cast<size_t>(map.size.height));
    const double weight = std::cos(angles_from_pixel({0.0, row}, map.size).phi_rad);
    const double confidence = map.confidence[p] / 255.0;
    total += weight;
    summary.mean_confidence += weight * confidence;
    if (map.confidence[p] < kMinConfidence) summary.low_share += weight;
    if (map.inverse[p] * pixels_per_inverse_m >= 1.0) summary.parallax_share += weight;
  }
  summary.mean_confidence /= total;
  summary.low_share /= total;
  summary.parallax_share /= total;
  return summary;
}

// Of a line's stations, from the pixels in its finished volume.
void add_left_out(const Line& line, const DistanceVolume& volume,
                  std::vector<LeftOutSummary>* summaries) {
  const PanoramaSize size = volume.size();
  const auto above = [&](int row) { return std::cos(row * kPi / size.height); };
  std::map<int, double> shares;  // by station
  const std::vector<std::int32_t> runs = volume.left_out().stored_runs(size);
  for (size_t i = 0; i < runs.size(); i += 4) {
    shares[runs[i]] += (above(runs[i + 2]) - above(runs[i + 3])) / (2.0 * size.width);
  }
  for (const auto& [station, share] : shares) {
    summaries->push_back(
        {line.id, station, line.stations[static_cast<size_t>(station)].file, share});
  }
}

}  // namespace

std::vector<MapSummary> map_summaries(const Grid& grid, const DepthPlan& plan,
                                      const PartialMaps& partial) {
  std::vector<MapSummary> summaries(plan.maps.size());
  parallel_for(0, static_cast<int>(plan.maps.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      const StationIndex station = plan.maps[i].station;
      summaries[i] = map_summary(partial.stored(kFinalStage, station), grid.line_of(station),
                                 plan.pixels_per_inverse_m());
    }
  });
  return summaries;
}

std::vector<LeftOutSummary> left_out_summaries(const Grid& grid,
                                               const std::vector<DistanceVolume>& volumes) {
  std::vector<LeftOutSummary> summaries;
  for (size_t l = 0; l < volumes.size(); ++l) {
    if (volumes[l].maps() > 0) add_left_out(grid.lines[l], volumes[l], &summaries);
  }
  return summaries;
}

double DepthSummary::low_confidence_share() const {
  double sum = 0.0;  // every map is a whole sphere
  for (const MapSummary& map : maps) sum += map.low_share;
  return maps.empty() ? 0.0 : sum / static_cast<double>(maps.size());
}

double DepthSummary::left_out_share() const {
  double sum = 0.0;
  for (const LeftOutSummary& station : left_out) sum += station.share;
  return stations == 0 ? 0.0 : sum / stations;
}

std::string text_of(const TruthComparison& truth) {
  return fmt::format(
      "{:.1f} % of the pixels within 1 px of parallax at the reach, {:.1f} % within 2, {:.1f} % "
      "within 4; median error of the distance {:.2f} %",
      100.0 * truth.within_1px_share, 100.0 * truth.within_2px_share,
      100.0 * truth.within_4px_share, 100.0 * truth.median_relative_error);
}

std::string text_of(const DepthSummary& summary) {
  std::string text = fmt::format(
      "{}: {} distance maps of {} x {}, estimated by {}; see {}\n"
      "low confidence (below {:.2f}) in {:.1f} % of the solid angle\n",
      summary.room, summary.maps.size(), summary.size.width, summary.size.height, summary.method,
      summary.page, kMinConfidence / 255.0, 100.0 * summary.low_confidence_share());
  if (!summary.left_out.empty()) {
    text += fmt::format(
        "left out of views, as it moved: {:.2g} % of the solid angle, in {}; --keep-moving keeps "
        "it\n",
        100.0 * summary.left_out_share(), counted(summary.left_out.size(), "station"));
  }
  if (summary.truth) {
    text += fmt::format("compared with the given distances, {}: {}\n",
                        counted(static_cast<std::size_t>(summary.truth->maps), "map"),
                        text_of(*summary.truth));
  }
  if (summary.gains) text += text_of(*summary.gains) + "\n";
  return text + use_text(summary) + "\n";
}

void require_usable(const DepthSummary& summary) {
  constexpr double kMostLowShare = 0.7;
  const double share = summary.low_confidence_share();
  if (share <= kMostLowShare) return;
  throw Error(fmt::format(
      "{}: not usable between stations: distances have low confidence in {:.0f} % of the solid "
      "angle; stations too far apart for what is near, plain or moving surfaces, or positions that "
      "are not those of the pictures (raywalk-calibrate finds them); see {}",
      summary.room, 100.0 * share, summary.page));
}

ordered_json depth_document(const DepthSummary& summary) {
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
                    {"largest_exposure_step", summary.largest_exposure_step},
                    {"distances", summary.distances},
                    {"low_confidence_below", kMinConfidence / 255.0},
                    {"low_confidence_share", summary.low_confidence_share()},
                    {"leave_out_moving", summary.leave_out_moving},
                    {"left_out_share", summary.left_out_share()},
                    {"seconds", summary.seconds},
                    {"peak_memory_mb", summary.peak_memory_mb},
                    {"warnings", summary.warnings}};
  json["frame_findings"] = ordered_json::array();
  for (const FrameFinding& finding : summary.frame_findings) {
    json["frame_findings"].push_back(json_of(finding));
  }
  json["left_out"] = json_of(summary.left_out);
  json["truth"] = summary.truth ? json_of(*summary.truth) : ordered_json(nullptr);
  json["gains"] = summary.gains ? json_of(*summary.gains) : ordered_json(nullptr);
  json["maps"] = ordered_json::array();
  for (const MapSummary& map : summary.maps) json["maps"].push_back(json_of(map));
  return json;
}

std::vector<std::string> parallax_warnings(std::span<const MapSummary> maps, double far_m) {
  constexpr double kMinShare = 0.01;  // false matches
  std::vector<std::string> warnings;
  for (size_t first = 0, end = 0; first < maps.size(); first = end) {
    double share = 0.0;
    for (; end < maps.size() && maps[end].line == maps[first].line; ++end) {
      share = std::max(share, maps[end].parallax_share);
    }
    if (share >= kMinShare) continue;
    warnings.push_back(fmt::format(
        "line {} shows no parallax: its view is farther than {:.3g} m or without texture, or "
        "the camera did not move along it",
        maps[first].line, far_m));
  }
  return warnings;
}

}  // namespace raywalk::build_lf
