#include "core/evaluate/trade_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/evaluate/measured_settings.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// The valid image width nearest to a share of another width.
int width_of_share(int width_px, double share) {
  return std::max(4, 4 * static_cast<int>(std::lround(share * width_px / 4.0)));
}

// A parameter's value as part of a setting's name; threads are no dial.
std::string phrase(const std::string& parameter, const ordered_json& value) {
  const std::string text =
      value.is_string() ? value.get<std::string>() : fmt::format("{:g}", value.get<double>());
  if (parameter == "threads") return "threads " + text;
  return fmt::format(fmt::runtime(dial_of(parameter).phrase), text);
}

// The generation and the differences from its central setting.
std::string name_of(const TradeSetting& setting, const TradeSetting& centre) {
  const ordered_json parameters = parameters_of(setting), before = parameters_of(centre);
  std::string name = generation_name(setting.options.generation);
  for (const auto& [parameter, value] : parameters.items()) {
    if (value != before.at(parameter)) name += ", " + phrase(parameter, value);
  }
  return name;
}

// Collects variations of the central settings without duplicates.
class Sweep {
 public:
  explicit Sweep(const SweepBase& base) {
    for (const ViewOptions& options : base.centres) {
      TradeSetting centre{generation_name(options.generation), options, base.threads};
      centre.options.width = base.width_px;
      centres_.push_back(centre);
    }
    settings_ = centres_;
  }

  // Adds the central setting of a generation, where the room supports it, changed by `change`.
  template <typename Change>
  void add(Generation generation, const Change& change) {
    for (const TradeSetting& centre : centres_) {
      if (centre.options.generation != generation) continue;
      TradeSetting setting = centre;
      change(&setting);
      // Others have no second side.
      if (generation != Generation::kTwoSided) {
        setting.options.second_side = centre.options.second_side;
      }
      setting.name = name_of(setting, centre);
      if (find_setting(settings_, setting) == settings_.size()) settings_.push_back(setting);
    }
  }

  std::vector<TradeSetting> take() { return std::move(settings_); }

 private:
  std::vector<TradeSetting> centres_;
  std::vector<TradeSetting> settings_;
};

}  // namespace

ordered_json parameters_of(const TradeSetting& setting) {
  ordered_json parameters = swept_dials_json(setting.options);
  parameters["threads"] = setting.threads;
  return parameters;
}

std::size_t find_setting(std::span<const TradeSetting> settings, const TradeSetting& wanted) {
  const auto found = std::ranges::find_if(settings, [&](const TradeSetting& setting) {
    return parameters_of(setting) == parameters_of(wanted);
  });
  return static_cast<std::size_t>(found - settings.begin());
}

std::vector<TradeSetting> trade_sweep(const SweepBase& base) {
  Sweep sweep(base);
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    const Generation generation =
        dial.sweep->of_two_sided_views ? Generation::kTwoSided : Generation::kHlfVd;
    for (const double value : dial.sweep->values) {
      sweep.add(generation, [&](TradeSetting* setting) {
        dial.value.set(&setting->options,
                       dial.sweep->of_truth_width ? width_of_share(base.width_px, value) : value);
      });
    }
  }
  sweep.add(Generation::kHlfVd, [](TradeSetting* setting) { setting->threads = 1; });
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    // All approximations for speed, and those that are hardly visible.
    for (const int distance_maps : {1, 2}) {
      sweep.add(generation, [&](TradeSetting* setting) {
        setting->options.distance_maps = distance_maps;
        setting->options.second_side = SecondSide::kFaded;
      });
    }
    // For accuracy.
    for (const SecondSide second_side : {SecondSide::kEverywhere, SecondSide::kFaded}) {
      sweep.add(generation, [&](TradeSetting* setting) {
        setting->options.interpolation = Interpolation::kCubic;
        setting->options.stations_mixed = 8;
        setting->options.second_side = second_side;
      });
    }
  }
  return sweep.take();
}

}  // namespace raywalk
