// Which settings a trade measures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/view/view_options.h"

namespace raywalk {

struct TradeSetting {
  std::string name{};     // "hlf-vd, cubic, stations 8", unique within a sweep
  ViewOptions options{};  // its width is that of the rendered image, pixels
  int threads = 1;        // at least 1
};

// Every parameter by name: {"generation": "hlf-vd", "k_deg": 76.0, ..., "threads": 2}. Two settings
// are the same where these are equal.
nlohmann::ordered_json parameters_of(const TradeSetting& setting);

// Position of the setting with the same parameters; the number of settings where there is none.
std::size_t find_setting(std::span<const TradeSetting> settings, const TradeSetting& wanted);

// Input of a sweep.
struct SweepBase {
  std::vector<ViewOptions> centres{};  // of each generation the central setting, at any width
  int width_px = 0;                    // of the truths
  int threads = 1;                     // all that may be used
};

// The central settings, variations of one dial at a time (Dial::sweep), and useful combinations
// (all for speed, all for accuracy, a balance): about 25.
std::vector<TradeSetting> trade_sweep(const SweepBase& base);

}  // namespace raywalk
