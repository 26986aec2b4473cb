#include "core/judge/trade/view_time.h"

#include <algorithm>
#include <ctime>
#include <limits>

#include "core/base/median.h"

namespace raywalk {
namespace {

constexpr double kClockStep_s = 1.0 / CLOCKS_PER_SEC;  // resolution of std::clock
constexpr double kLargestSpread = 0.25;
constexpr double kLargestSlowdown = 0.25;
constexpr double kLargestShareOfOthers = 0.05;

double least_remap_ms(std::span<const ViewTime> times) {
  double least_ms = std::numeric_limits<double>::infinity();
  for (const ViewTime& time : times) least_ms = std::min(least_ms, time.remap_ms);
  return least_ms;
}

double spread_of(std::vector<double> times_s) {
  std::ranges::sort(times_s);
  return times_s[times_s.size() * 3 / 4] / times_s.front() - 1.0;
}

}  // namespace

ViewTime view_time_of(std::span<const TimedPair> pairs, double others_share) {
  std::vector<double> view_s, remap_s, ratios, cpu_ratios;
  for (const auto& [remap, view] : pairs) {
    view_s.push_back(view.wall_s);
    remap_s.push_back(remap.wall_s);
    ratios.push_back(view.wall_s / remap.wall_s);
    cpu_ratios.push_back(view.cpu_s / std::max(remap.cpu_s, kClockStep_s));
  }
  return {.ms = 1e3 * median(view_s),
          .ratio = median(ratios),
          .cpu_ratio = median(cpu_ratios),
          .remap_ms = 1e3 * median(remap_s),
          .remap_spread = spread_of(remap_s),
          .others_share = others_share};
}

double disturbance(const ViewTime& time, double least_remap_ms) {
  return std::max({time.remap_spread / kLargestSpread,
                   (time.remap_ms / least_remap_ms - 1.0) / kLargestSlowdown,
                   time.others_share / kLargestShareOfOthers});
}

std::vector<bool> disturbed(std::span<const ViewTime> times) {
  const double least_ms = least_remap_ms(times);
  std::vector<bool> found;
  for (const ViewTime& time : times) found.push_back(disturbance(time, least_ms) > 1.0);
  return found;
}

void repeat_disturbed(std::vector<ViewTime>* times,
                      const std::function<void(std::ptrdiff_t)>& begin_round,
                      const std::function<ViewTime(std::size_t)>& measure,
                      const std::function<void(std::size_t)>& kept) {
  for (int round = 0; round < kDisturbedRounds; ++round) {
    const std::vector<bool> again = disturbed(*times);
    const std::ptrdiff_t count = std::ranges::count(again, true);
    if (count == 0) return;
    begin_round(count);
    for (std::size_t i = 0; i < times->size(); ++i) {
      if (!again[i]) continue;
      const ViewTime time = measure(i);
      const double least_ms = std::min(least_remap_ms(*times), time.remap_ms);
      if (disturbance(time, least_ms) >= disturbance((*times)[i], least_ms)) continue;
      (*times)[i] = time;
      kept(i);
    }
  }
}

}  // namespace raywalk
