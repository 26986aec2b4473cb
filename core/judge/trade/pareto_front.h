// The Pareto front: settings that no other setting dominates.
#pragma once

#include <span>
#include <vector>

namespace raywalk {

// Cost (smaller is better) and gain (larger is better) of a setting. A point that is not finite is
// dominated by any finite one.
struct TradePoint {
  double cost = 0.0;
  double gain = 0.0;
};

// For each point whether it is on the front: no other point is at least as good in both and better
// in one. Equal points are both on the front or both not.
std::vector<bool> pareto_front(std::span<const TradePoint> points);

}  // namespace raywalk
