// Which settings a trade measures.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/judge/trade/trade_setting.h"
#include "core/judge/trade/trade_view.h"

namespace raywalk {

// Input of a sweep.
struct SweepBase {
  // The central setting of each generation, as view_modes chooses them; options.width is not used.
  std::vector<ViewMode> centres{};
  std::span<const TradeRoom> rooms{};  // the room under test first
  int width_px = 0;                    // of the truths
  int threads = 1;                     // all that may be used
};

// The central settings, variations of one dial at a time (DialSweep::singly), and useful
// combinations (all for speed, all for accuracy, a balance): about 25.
std::vector<TradeSetting> quick_sweep(const SweepBase& base);

// The quick sweep and full grids of the dials that interact (DialSweep::in_grid): those that choose
// and read samples, and those of the view's layout, with the number of threads, each for every
// generation; in the other rooms every generation and interpolation. About 170.
std::vector<TradeSetting> full_sweep(const SweepBase& base);

}  // namespace raywalk
