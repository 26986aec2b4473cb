#include "core/judge/trade/pareto_front.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

namespace raywalk {

std::vector<bool> pareto_front(std::span<const TradePoint> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) {
    return !std::isfinite(points[i].cost) || !std::isfinite(points[i].gain);
  });
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    if (points[a].cost != points[b].cost) return points[a].cost < points[b].cost;
    return points[a].gain > points[b].gain;
  });
  std::vector<bool> front(points.size(), false);
  // The point of largest gain among those of no larger cost.
  TradePoint best{0.0, -std::numeric_limits<double>::infinity()};
  for (const std::size_t i : order) {
    const bool equal = points[i].gain == best.gain && points[i].cost == best.cost;
    if (!equal && !(points[i].gain > best.gain)) continue;
    front[i] = true;
    best = points[i];
  }
  return front;
}

}  // namespace raywalk
