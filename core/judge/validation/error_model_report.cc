#include "core/judge/validation/error_model_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/geometry/connection_error.h"
#include "core/report/report.h"

namespace raywalk {
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
// Distances closer together than this (in N) count as one sample of the sweep.
constexpr double kSameDistance = 1e-6;

struct StatedOptimum {
  double distance_over_side;
  int k_deg;
};
// Section IV-B of the paper: 76 degrees at 1.5 N; 87 to 72 degrees over 1.2 N to 2.5 N.
constexpr std::array<StatedOptimum, 3> kStatedOptima{{{1.2, 87}, {1.5, 76}, {2.5, 72}}};

struct DistanceCurve {
  double distance_over_side = 0.0;
  ConnectionErrorCurve errors;
};

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

bool same_distance(double a, double b) { return std::abs(a - b) < kSameDistance; }

bool is_among(const std::vector<double>& distances, double distance) {
  return std::ranges::any_of(distances,
                             [&](double known) { return same_distance(known, distance); });
}

std::vector<double> sorted_distances(const ErrorModelOptions& options) {
  std::vector<double> distances = options.distances_over_side;
  std::ranges::sort(distances);
  distances.erase(std::unique(distances.begin(), distances.end(), same_distance), distances.end());
  return distances;
}

// The given distances and kSweepSamples equally spaced ones between the least and the greatest.
std::vector<double> sweep_distances(const std::vector<double>& given) {
  std::vector<double> sweep = given;
  for (int i = 0; i < kSweepSamples; ++i) {
    const double sample =
        std::lerp(given.front(), given.back(), static_cast<double>(i) / (kSweepSamples - 1));
    if (!is_among(sweep, sample)) sweep.push_back(sample);
  }
  std::ranges::sort(sweep);
  return sweep;
}

std::vector<DistanceCurve> compute_curves(const ErrorModelOptions& options,
                                          const std::vector<double>& distances) {
  const CellSampling sampling{
      .side_m = options.side_m, .step_m = options.step_m, .viewpoints = options.viewpoints};
  std::vector<DistanceCurve> curves(distances.size());
  parallel_for(0, static_cast<int>(distances.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const double distance = distances[static_cast<std::size_t>(i)];
      const double distance_m = distance * options.side_m;
      curves[static_cast<std::size_t>(i)] = {
          distance, connection_error_curve(sampling, std::span(&distance_m, 1))};
    }
  });
  return curves;
}

// The paper's optimum; null where it states none.
Json stated_k_deg(double distance) {
  for (const StatedOptimum& stated : kStatedOptima) {
    if (same_distance(stated.distance_over_side, distance)) return stated.k_deg;
  }
  return nullptr;
}

// Of error-model.json. `given`: sorted.
Json document_of(const ErrorModelOptions& options, const std::vector<double>& given,
                 const std::vector<DistanceCurve>& curves) {
  Json json{
      {"side_m", options.side_m}, {"step_m", options.step_m}, {"viewpoints", options.viewpoints}};
  for (int k = ConnectionErrorCurve::kMinDeg; k <= ConnectionErrorCurve::kMaxDeg; ++k) {
    json["k_deg"].push_back(k);
  }
  for (const DistanceCurve& curve : curves) {
    const double distance = curve.distance_over_side;
    const ConnectionErrorCurve& errors = curve.errors;
    if (same_distance(distance, given[given.size() / 2])) json["detail"] = json["curves"].size();
    json["curves"].push_back({{"d_src_m", distance * options.side_m},
                              {"d_src_over_side", distance},
                              {"e_m_rad", errors.mismatch_rad},
                              {"e_b_rad", errors.bending_rad},
                              {"e_t", errors.total},
                              {"optimum_k_deg", errors.optimum_k_deg},
                              {"least_e_t", *std::ranges::min_element(errors.total)},
                              {"paper_k_deg", stated_k_deg(distance)},
                              {"given", is_among(given, distance)}});
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
  const std::vector<double> given = sorted_distances(options);
  const Json document =
      document_of(options, given, compute_curves(options, sweep_distances(given)));
  write_file_atomically(options.report_dir / "error-model.json", json_text(document));
  write_file_atomically(options.report_dir / "index.html", report_page("error_model", document));
  print_table(document, table);
}

}  // namespace raywalk
