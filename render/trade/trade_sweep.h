// Which settings a trade measures.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/trade/trade_setting.h"
#include "render/trade/trade_view.h"

namespace raywalk::render {

// What a sweep is made from.
struct SweepBase {
  // The central setting of each generation, as view_modes chooses them; options.width is not used.
  std::vector<ViewMode> centres{};
  std::span<const TradeRoom> rooms{};  // the first is the one that the trade is about
  int width_px = 0;                    // of the truths
  int threads = 1;                     // all that may be used
};

// The central settings, one parameter at a time moved from them, and combinations that go together
// (everything for speed, everything for accuracy, what lies between): about 40.
std::vector<TradeSetting> quick_sweep(const SweepBase& base);

// The quick sweep and the grids of the parameters that interact: those of how samples are chosen and
// read (interpolation, stations_mixed, second_side, distance_maps, skip_px, station_stride), and
// those of how the view is laid out (k, overlap, layers, width, arithmetic, threads), each at every
// generation; of the other rooms every generation and interpolation. About a thousand.
std::vector<TradeSetting> full_sweep(const SweepBase& base);

}  // namespace raywalk::render
