#include "core/view/column_sources.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace raywalk {

ColumnSources column_sources(const ColumnPlan& plan, const ViewOptions& options) {
  ColumnSources sources;
  double span_m = 0.0;
  const auto add = [&](const std::array<RaySource, 2>& lines, int count) {
    for (const RaySource& line : std::span(lines).first(static_cast<std::size_t>(count))) {
      sources.source[sources.count++].at = line;
      span_m += std::abs(line.d_p_m);
    }
  };
  add(plan.front, plan.front_count);
  if (options.method == ViewMethod::kTwoSided) add(plan.behind, plan.behind_count);
  const std::span used(sources.source.data(), sources.count);

  double total = 0.0, behind = 0.0;
  std::array<double, kMaxSources> share{};
  for (std::size_t i = 0; i < used.size(); ++i) {
    constexpr double kLeast = 1e-4;  // a line that the eye is on counts alone, nearly
    const double away = std::abs(used[i].at.d_p_m) / std::max(span_m, 1e-9);
    share[i] = used[i].at.weight / (away + kLeast);
    total += share[i];
    if (used[i].behind()) behind += share[i];
  }
  behind /= total;
  const bool faded = options.method == ViewMethod::kTwoSided &&
                     options.second_side == SecondSide::kFaded && behind > 0.0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    double part = share[i] / total;
    if (faded) {
      constexpr double kTrace = 1e-5;
      const double faded_behind = std::clamp(3.0 * behind - 1.0, 0.0, 1.0);
      const double side = used[i].behind() ? behind : 1.0 - behind;
      const double faded_side = used[i].behind() ? faded_behind : 1.0 - faded_behind;
      part *= std::max(faded_side, kTrace) / std::max(side, 1e-9);
    }
    used[i].share = static_cast<float>(part);
  }
  return sources;
}

StationWindow stations_mixed(const RaySource& at, int stations_of_line, StationMix mix) {
  const double met = at.station + at.fraction;
  const double reach = 0.5 * (mix.stations + mix.fade);
  return {std::max(static_cast<int>(std::ceil(met - reach)), 0),
          std::min(static_cast<int>(std::floor(met + reach)), stations_of_line - 1)};
}

}  // namespace raywalk
