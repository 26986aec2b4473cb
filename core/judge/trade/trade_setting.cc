#include "core/judge/trade/trade_setting.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// A parameter's value as part of a setting's name.
std::string phrase(const std::string& parameter, const ordered_json& value) {
  static const std::map<std::string, const char*> kPhrases{{"k_deg", "k {}°"},
                                                           {"overlap_deg", "overlap {}°"},
                                                           {"layers", "layers {}"},
                                                           {"width_px", "{} px wide"},
                                                           {"interpolation", "{}"},
                                                           {"arithmetic", "{}"},
                                                           {"stations_mixed", "{} station mixed"},
                                                           {"station_stride", "stride {}"},
                                                           {"distance_maps", "maps {}"},
                                                           {"fill_stations", "fill {}"},
                                                           {"second_side", "second side {}"},
                                                           {"skip_px", "skip {} px"},
                                                           {"threads", "threads {}"},
                                                           {"stored_width_px", "stored {} px wide"},
                                                           {"depth", "depth {}"}};
  const auto found = kPhrases.find(parameter);
  return fmt::format(fmt::runtime(found == kPhrases.end() ? "{}" : found->second),
                     parameter_text(value));
}

}  // namespace

ordered_json parameters_of(const TradeSetting& setting) {
  const ViewOptions& options = setting.mode.options;
  return {{"generation", generation_name(options.generation)},
          {"k_deg", options.k_deg},
          {"overlap_deg", options.overlap_deg},
          {"layers", options.layers == 0 ? ordered_json("auto") : ordered_json(options.layers)},
          {"width_px", options.width},
          {"interpolation", interpolation_name(options.interpolation)},
          {"arithmetic", arithmetic_name(options.arithmetic)},
          {"stations_mixed", options.stations_mixed},
          {"station_stride", options.station_stride},
          {"distance_maps", options.distance_maps},
          {"fill_stations", options.fill_stations},
          {"second_side", second_side_name(options.second_side)},
          {"skip_px", options.skip_px},
          {"threads", setting.threads},
          {"stored_width_px", setting.stored_width_px},
          {"depth", setting.depth}};
}

std::string parameter_text(const ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : fmt::format("{:g}", value.get<double>());
}

std::vector<std::string> changed_parameters(const TradeSetting& setting, const TradeSetting& from) {
  const ordered_json parameters = parameters_of(setting);
  const ordered_json before = parameters_of(from);
  std::vector<std::string> moved;
  for (const auto& [parameter, value] : parameters.items()) {
    if (value != before.at(parameter)) moved.push_back(parameter);
  }
  return moved;
}

std::string name_of(const TradeSetting& setting, const TradeSetting& centre) {
  const ordered_json parameters = parameters_of(setting);
  std::string name = generation_name(setting.mode.options.generation);
  for (const std::string& parameter : changed_parameters(setting, centre)) {
    name += ", " + phrase(parameter, parameters.at(parameter));
  }
  return name;
}

}  // namespace raywalk
