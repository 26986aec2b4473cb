// Which settings a trade measures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/view/view_mode.h"

namespace raywalk {

struct TradeSetting {
  std::string name{};  // "hlf-vd, cubic, stations 8", unique within a sweep
  ViewMode mode{};     // options.width is the width of the rendered image, pixels
  int threads = 1;     // at least 1
};

// Every parameter by name: {"generation": "hlf-vd", "k_deg": 76.0, ..., "threads": 2}. Two settings
// are the same where these are equal.
nlohmann::ordered_json parameters_of(const TradeSetting& setting);

// Input of a sweep.
struct SweepBase {
  // The central setting of each generation, as view_modes chooses them; options.width is not used.
  std::vector<ViewMode> centres{};
  int stored_width_px = 0;  // of the room's panoramas
  int width_px = 0;         // of the truths
  int threads = 1;          // all that may be used
};

// The central settings, variations of one dial at a time (Dial::sweep), and useful combinations
// (all for speed, all for accuracy, a balance): about 25.
std::vector<TradeSetting> trade_sweep(const SweepBase& base);

}  // namespace raywalk
