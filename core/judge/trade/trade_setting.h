// One setting of all rendering parameters.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/view/view_mode.h"

namespace raywalk {

struct TradeSetting {
  std::string name{};                // name_of(), unique within a sweep
  ViewMode mode{};                   // options.width is the width of the rendered picture, pixels
  int threads = 1;                   // at least 1
  std::size_t room = 0;              // index into the rooms of the trade; 0 is the room under test
  int stored_width_px = 0;           // of that room's panoramas
  std::string depth{};               // of that room's distances: depth_name
  std::string compression = "none";  // of that room: Room::compression
};

// Every parameter by name, in the order of the tables; numbers as JSON numbers: {"generation":
// "hlf-vd", "k_deg": 76.0, ...}. Two settings are the same where these are equal.
nlohmann::ordered_json parameters_of(const TradeSetting& setting);

// The parameters that differ from those of another setting, in the order of parameters_of.
std::vector<std::string> changed_parameters(const TradeSetting& setting, const TradeSetting& from);

// The generation and the differences from its central setting: "hlf-vd, cubic, stations 8".
// Different settings have different names.
std::string name_of(const TradeSetting& setting, const TradeSetting& centre);

}  // namespace raywalk
