#include "core/evaluate/trade/view_time.h"

#include <algorithm>
#include <vector>

#include "core/base/median.h"

namespace raywalk {

ViewTime view_time_of(std::span<const TimedPair> pairs) {
  std::vector<double> view_s, remap_s, ratios;
  for (const TimedPair& pair : pairs) {
    view_s.push_back(pair.view_s);
    remap_s.push_back(pair.remap_s);
    ratios.push_back(pair.view_s / pair.remap_s);
  }
  std::ranges::sort(remap_s);
  return {.ms = 1e3 * median(view_s),
          .ratio = median(ratios),
          .remap_ms = 1e3 * median(remap_s),
          .remap_spread = remap_s[remap_s.size() * 3 / 4] / remap_s.front() - 1.0};
}

}  // namespace raywalk
