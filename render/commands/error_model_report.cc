#include "render/commands/error_model_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"
#include "core/geometry/error_model.h"
#include "core/report/report.h"

namespace raywalk::render {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMaxModelViewpoints = 1000;
// Cells and distances that somebody may mean: from a model on a table to a stadium.
constexpr double kLeastSide_m = 0.01;
constexpr double kMostSide_m = 1000.0;
constexpr double kLeastStep = 1e-5;     // in multiples of the side
constexpr double kLeastDistance = 0.1;  // in multiples of the side
constexpr double kMostDistance = 10000.0;
// Steps of 0.1 N over the paper's range 1.2 N to 2.5 N.
constexpr int kSweepSamples = 14;

// Section IV-B of the paper: 76 degrees at 1.5 N; 87 to 72 degrees over 1.2 N to 2.5 N.
struct StatedOptimum {
  double distance_over_side;
  int k_deg;
};
constexpr std::array<StatedOptimum, 3> kStatedOptima{{{1.2, 87}, {1.5, 76}, {2.5, 72}}};

// Throws unless `value` is in [least, most]; NaN is in no range.
void require_range(const std::string& what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw UsageError(
      fmt::format("error-model: {} is {:g}; it must be {:g} to {:g}", what, value, least, most));
}

void check_options(const ErrorModelOptions& options) {
  require_range("the cell's side (m)", options.side_m, kLeastSide_m, kMostSide_m);
  require_range("the station step (m)", options.step_m, kLeastStep * options.side_m,
                options.side_m);
  require_range("the number of viewpoints per side", options.viewpoints, 1, kMaxModelViewpoints);
  if (options.distances_over_side.empty()) {
    throw UsageError("error-model: give at least one source distance");
  }
  for (const double distance : options.distances_over_side) {
    require_range("a source distance (in multiples of the cell's side)", distance, kLeastDistance,
                  kMostDistance);
  }
}

std::vector<double> sorted_once(std::vector<double> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

// The given distances and kSweepSamples equally spaced ones between the least and the greatest,
// rounded so that they are those that somebody gives.
std::vector<double> sweep_distances(const std::vector<double>& given) {
  std::vector<double> sweep = given;
  const auto [least, most] = std::ranges::minmax(given);
  for (int i = 0; i < kSweepSamples; ++i) {
    const double sample = std::lerp(least, most, static_cast<double>(i) / (kSweepSamples - 1));
    sweep.push_back(std::clamp(std::round(1e9 * sample) / 1e9, least, most));
  }
  return sorted_once(std::move(sweep));
}

// The errors over k of sources at a distance, given in multiples of the side.
Json curve_at(double distance, const ErrorModelOptions& options) {
  const CellSampling sampling{
      .side_m = options.side_m, .step_m = options.step_m, .viewpoints = options.viewpoints};
  const double distance_m = distance * options.side_m;
  const ConnectionErrorCurve errors = connection_error_curve(sampling, distance_m);
  const auto* stated =
      std::ranges::find(kStatedOptima, distance, &StatedOptimum::distance_over_side);
  const auto& given = options.distances_over_side;
  return {{"d_src_m", distance_m},
          {"d_src_over_side", distance},
          {"e_m_rad", errors.mismatch_rad},
          {"e_b_rad", errors.bending_rad},
          {"e_t", errors.total},
          {"optimum_k_deg", errors.optimum_k_deg},
          {"least_e_t", *std::ranges::min_element(errors.total)},
          // Null where the paper states none.
          {"paper_k_deg", stated == kStatedOptima.end() ? Json() : Json(stated->k_deg)},
          {"given", std::ranges::find(given, distance) != given.end()}};
}

// Of error-model.json.
Json error_model(const ErrorModelOptions& options) {
  const std::vector<double> given = sorted_once(options.distances_over_side);
  const std::vector<double> distances = sweep_distances(given);
  std::vector<Json> curves(distances.size());
  parallel_for(0, static_cast<int>(distances.size()), 1, [&](int begin, int /*end*/) {
    const auto i = static_cast<std::size_t>(begin);
    curves[i] = curve_at(distances[i], options);
  });
  const auto detail = std::ranges::find(distances, given[given.size() / 2]);
  Json json{{"side_m", options.side_m},
            {"step_m", options.step_m},
            {"viewpoints", options.viewpoints},
            {"k_deg", Json::array()},
            {"detail", detail - distances.begin()},
            {"curves", curves}};
  for (int k = ConnectionErrorCurve::kMinDeg; k <= ConnectionErrorCurve::kMaxDeg; ++k) {
    json["k_deg"].push_back(k);
  }
  for (const StatedOptimum& stated : kStatedOptima) {
    json["paper"].push_back(
        {{"d_src_over_side", stated.distance_over_side}, {"optimum_k_deg", stated.k_deg}});
  }
  return json;
}

// The same for the terminal.
void print_table(const Json& document, std::ostream& table) {
  table << fmt::format(
      "Error model: N = {:g} m, station step {:g} m, {} x {} viewpoints, rows of 1 degree\n",
      document["side_m"].get<double>(), document["step_m"].get<double>(),
      document["viewpoints"].get<int>(), document["viewpoints"].get<int>());
  table << fmt::format("{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "d_src / N", "d_src (m)",
                       "optimum k", "paper's k", "E_t", "E_t at 45", "E_t at 90");
  for (const Json& curve : document["curves"]) {
    const Json& paper = curve["paper_k_deg"];
    table << fmt::format(
        "{:11g}{:11g}{:11}{:>11}{:11.4f}{:11.4f}{:11.4f}\n", curve["d_src_over_side"].get<double>(),
        curve["d_src_m"].get<double>(), curve["optimum_k_deg"].get<int>(),
        paper.is_null() ? "-" : std::to_string(paper.get<int>()), curve["least_e_t"].get<double>(),
        curve["e_t"].front().get<double>(), curve["e_t"].back().get<double>());
  }
}

}  // namespace

void write_error_model_report(const ErrorModelOptions& options, std::ostream& table) {
  check_options(options);
  make_directories(options.report_dir);
  const Json document = error_model(options);
  write_file_atomically(options.report_dir / "error-model.json", json_text(document));
  write_file_atomically(options.report_dir / "index.html", report_page("error_model", document));
  print_table(document, table);
}

}  // namespace raywalk::render
