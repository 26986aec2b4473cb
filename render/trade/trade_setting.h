// One setting of all parameters, to be measured against others.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "render/validation/view_mode.h"

namespace raywalk::render {

struct TradeSetting {
  std::string name{};       // tells it from all others of a sweep: name_of
  ViewMode mode{};          // options.width is that of the picture as it is rendered, pixels
  int threads = 1;          // at least 1
  std::size_t room = 0;     // index into the rooms of the trade; 0 is the one it is about
  int stored_width_px = 0;  // of that room's panoramas
  std::string depth{};      // of that room's distances: depth_name
};

// Every parameter by its name, in the order of tables, numbers as numbers: {"generation": "hlf-vd",
// "k_deg": 76.0, ...}; `layers` is "auto" where as many are used as the tolerance needs. Two
// settings are alike where these are equal.
nlohmann::ordered_json parameters_of(const TradeSetting& setting);

// A parameter's value as it is read in tables.
std::string parameter_text(const nlohmann::ordered_json& value);

// The parameters that differ from those of another setting, in the order of parameters_of.
std::vector<std::string> changed_parameters(const TradeSetting& setting, const TradeSetting& from);

// The generation, and what differs from the central setting of it, in words: "hlf-vd, nearest, 1
// station mixed". Unique where the settings differ.
std::string name_of(const TradeSetting& setting, const TradeSetting& centre);

}  // namespace raywalk::render
