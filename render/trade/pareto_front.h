// Which settings are worth having: those that no other beats.
#pragma once

#include <span>
#include <vector>

namespace raywalk::render {

// What a setting costs, smaller is better, and what it gives, larger is better. A point that is not
// finite is beaten by any.
struct TradePoint {
  double cost = 0.0;
  double gain = 0.0;
};

// For each point whether no other is at least as good in both and better in one. Equal points are
// both on the front or both not.
std::vector<bool> pareto_front(std::span<const TradePoint> points);

}  // namespace raywalk::render
