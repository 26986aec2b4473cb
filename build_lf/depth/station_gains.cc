#include "build_lf/depth/station_gains.h"

#include <cmath>

#include "core/panorama/gain_graph.h"

namespace raywalk::build_lf {
namespace {

// Numbers all stations, line after line.
class StationNumbers {
 public:
  explicit StationNumbers(const Grid& grid) {
    for (const Line& line : grid.lines) {
      first_.push_back(count_);
      count_ += static_cast<int>(line.stations.size());
    }
  }
  int of(StationIndex station) const {
    return first_[static_cast<size_t>(station.line)] + station.station;
  }
  int count() const { return count_; }

 private:
  std::vector<int> first_;
  int count_ = 0;
};

}  // namespace

StationGains solve_gains(const Grid& grid, std::span<const StationLink> links) {
  const StationNumbers numbers(grid);
  StationGains result;
  for (const Line& line : grid.lines) {
    result.gain.emplace_back(line.stations.size(), ColourGain(1.0f, 1.0f, 1.0f));
  }
  for (size_t channel = 0; channel < 3; ++channel) {
    std::vector<GainEquation> equations;
    for (const StationLink& link : links) {
      if (!link.comparable) continue;
      const int from = numbers.of(link.pair.from);
      const int to = numbers.of(link.pair.to);
      equations.push_back({from, to, link.log_ratio[channel], link.log_ratio_error[channel]});
    }
    const Eigen::VectorXd log_gain = solve_gain_graph(equations, numbers.count());
    for (size_t line = 0; line < result.gain.size(); ++line) {
      for (size_t i = 0; i < result.gain[line].size(); ++i) {
        const int number = numbers.of({static_cast<int>(line), static_cast<int>(i)});
        result.gain[line][i][static_cast<int>(channel)] =
            static_cast<float>(std::exp(log_gain[number]));
      }
    }
  }
  return result;
}

std::vector<std::vector<GainField>> whole_fields(const StationGains& gains) {
  std::vector<std::vector<GainField>> fields;
  for (const std::vector<ColourGain>& line : gains.gain) {
    std::vector<GainField>& of_line = fields.emplace_back();
    for (const ColourGain& gain : line) of_line.push_back({gain, {}});
  }
  return fields;
}

// Levels times gains agree, so levels are inversely proportional to gains.
double log_exposure_step(std::span<const ColourGain> gains, int station) {
  const ColourGain& before = gains[static_cast<size_t>(station) - 1];
  const ColourGain& after = gains[static_cast<size_t>(station)];
  double largest = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double step = std::log(static_cast<double>(before[c]) / after[c]);
    if (std::fabs(step) > std::fabs(largest)) largest = step;
  }
  return largest;
}

}  // namespace raywalk::build_lf
