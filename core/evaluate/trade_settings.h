// Which settings a trade measures.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/view/gpu/gpu_device.h"
#include "core/view/view_options.h"

namespace raywalk {

struct TradeSetting {
  std::string name{};     // "hlf-vd, cubic, stations 8", unique within a sweep
  ViewOptions options{};  // its width is that of the rendered image, pixels
  int threads = 1;        // at least 1
  Device device = Device::kCpu;
};

// Every parameter by name: {"method": "hlf-vd", "k_deg": 76.0, ..., "threads": 2, "device": "cpu"}.
// Two settings are the same where these are equal.
nlohmann::ordered_json parameters_of(const TradeSetting& setting);

// Adds a setting unless one of the same parameters is there; its position in either case.
std::size_t add_setting(const TradeSetting& setting, std::vector<TradeSetting>* settings);

// The central settings (one of each method), variations of one parameter at a time
// (ViewParameter::sweep), and useful combinations (all for speed, all for accuracy, a balance):
// about 25. Images are as wide as the truths, `width_px`; `threads` are all that may be used.
std::vector<TradeSetting> trade_sweep(std::span<const ViewOptions> centres, int width_px,
                                      int threads);

// Adds all settings on `threads` threads a second time, on a device other than the processor.
void repeat_on(Device device, int threads, std::vector<TradeSetting>* settings);

}  // namespace raywalk
