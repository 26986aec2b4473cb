#include "core/judge/trade/trade_setting.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "core/judge/trade/dial_json.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

std::string parameter_text(const ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : fmt::format("{:g}", value.get<double>());
}

// A parameter's value as part of a setting's name.
std::string phrase(const std::string& parameter, const ordered_json& value) {
  // Those that are no dials.
  static const std::map<std::string, const char*> kPhrases{{"threads", "threads {}"},
                                                           {"stored_width_px", "stored {} px wide"},
                                                           {"depth", "depth {}"},
                                                           {"compression", "compression {}"}};
  const auto found = kPhrases.find(parameter);
  return fmt::format(
      fmt::runtime(found == kPhrases.end() ? dial_of(parameter).phrase : found->second),
      parameter_text(value));
}

}  // namespace

ordered_json parameters_of(const TradeSetting& setting) {
  ordered_json parameters = swept_dials_json(setting.mode.options);
  parameters["threads"] = setting.threads;
  parameters["stored_width_px"] = setting.stored_width_px;
  parameters["depth"] = setting.depth;
  parameters["compression"] = setting.compression;
  return parameters;
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
