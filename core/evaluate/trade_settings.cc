#include "core/evaluate/trade_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/evaluate/measured_settings.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// Changes a setting.
using Change = std::function<void(TradeSetting*)>;

// The valid image width nearest to a share of another width.
int width_of_share(int width_px, double share) {
  return std::max(4, 4 * static_cast<int>(std::lround(share * width_px / 4.0)));
}

// A parameter's value as part of a setting's name; threads are no parameter.
std::string phrase(const std::string& parameter, const ordered_json& value) {
  const std::string text =
      value.is_string() ? value.get<std::string>() : fmt::format("{:g}", value.get<double>());
  if (parameter == "threads") return "threads " + text;
  return fmt::format(fmt::runtime(parameter_of(parameter).phrase), text);
}

// The method and the differences from its central setting.
std::string name_of(const TradeSetting& setting, const TradeSetting& centre) {
  const ordered_json parameters = parameters_of(setting), before = parameters_of(centre);
  std::string name = method_name(setting.options.method);
  for (const auto& [parameter, value] : parameters.items()) {
    if (value != before.at(parameter)) name += ", " + phrase(parameter, value);
  }
  return name;
}

// What is varied of the views of a method.
std::vector<Change> changes_of(ViewMethod method, int width_px) {
  std::vector<Change> changes;
  if (method == ViewMethod::kInitial) return changes;
  const bool two_sided = method == ViewMethod::kTwoSided;
  for (const ViewParameter& parameter : kViewParameters) {
    if (!parameter.sweep || parameter.sweep->of_two_sided_views != two_sided) continue;
    for (const double value : parameter.sweep->values) {
      changes.emplace_back([&parameter, value, width_px](TradeSetting* setting) {
        parameter.value.set(&setting->options, parameter.sweep->of_truth_width
                                                   ? width_of_share(width_px, value)
                                                   : value);
      });
    }
  }
  if (!two_sided) changes.emplace_back([](TradeSetting* setting) { setting->threads = 1; });
  // All approximations for speed, and those that are hardly visible.
  for (const int distance_maps : {1, 2}) {
    changes.emplace_back([distance_maps](TradeSetting* setting) {
      setting->options.distance_maps = distance_maps;
      setting->options.second_side = SecondSide::kFaded;
    });
  }
  // For accuracy.
  for (const SecondSide second_side : {SecondSide::kEverywhere, SecondSide::kFaded}) {
    changes.emplace_back([second_side](TradeSetting* setting) {
      setting->options.interpolation = Interpolation::kCubic;
      setting->options.stations_mixed = 8;
      setting->options.second_side = second_side;
    });
  }
  return changes;
}

}  // namespace

ordered_json parameters_of(const TradeSetting& setting) {
  ordered_json parameters = swept_parameters_json(setting.options);
  parameters["threads"] = setting.threads;
  parameters["device"] = setting.device == Device::kCpu ? "cpu" : "gpu";
  return parameters;
}

std::size_t add_setting(const TradeSetting& setting, std::vector<TradeSetting>* settings) {
  const ordered_json parameters = parameters_of(setting);
  const auto found = std::ranges::find(*settings, parameters, parameters_of);
  const auto position = static_cast<std::size_t>(found - settings->begin());
  if (found == settings->end()) settings->push_back(setting);
  return position;
}

std::vector<TradeSetting> trade_sweep(std::span<const ViewOptions> centres, int width_px,
                                      int threads) {
  std::vector<TradeSetting> settings;
  for (const ViewOptions& options : centres) {
    settings.push_back({method_name(options.method), options, threads});
    settings.back().options.width = width_px;
  }
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const TradeSetting centre = settings[i];
    for (const Change& change : changes_of(centre.options.method, width_px)) {
      TradeSetting setting = centre;
      change(&setting);
      // Others have no second side.
      if (centre.options.method != ViewMethod::kTwoSided) {
        setting.options.second_side = centre.options.second_side;
      }
      setting.name = name_of(setting, centre);
      add_setting(setting, &settings);
    }
  }
  return settings;
}

void repeat_on(Device device, int threads, std::vector<TradeSetting>* settings) {
  const std::vector<TradeSetting> before = *settings;
  for (TradeSetting setting : before) {
    if (setting.threads != threads) continue;
    setting.device = device;
    setting.name += ", gpu";
    settings->push_back(setting);
  }
}

}  // namespace raywalk
