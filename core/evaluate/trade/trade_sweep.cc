#include "core/evaluate/trade/trade_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/evaluate/trade/dial_json.h"
#include "core/room/connection_errors.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// The valid image width nearest to a share of another width.
int width_of_share(int width_px, double share) {
  return std::max(4, 4 * static_cast<int>(std::lround(share * width_px / 4.0)));
}

// Whether columns of an initial view lie between captured ones, so that they are interpolated.
bool resampled(int stored_width_px, int width_px) {
  const double fold = std::max(1.0, std::round(double(stored_width_px) / width_px));
  return fold * width_px != stored_width_px;
}

bool has_effect(const Dial& dial, const ViewOptions& options, int stored_width_px) {
  switch (dial.effect) {
    case DialEffect::kAllViews:
      return true;
    case DialEffect::kSampledViews:
      return options.generation != Generation::kInitial ||
             resampled(stored_width_px, options.width);
    case DialEffect::kCorrectedViews:
      return options.generation != Generation::kInitial;
    case DialEffect::kTwoSidedViews:
      return options.generation == Generation::kTwoSided;
  }
  return true;
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
  std::string name = generation_name(setting.mode.options.generation);
  for (const auto& [parameter, value] : parameters.items()) {
    if (value != before.at(parameter)) name += ", " + phrase(parameter, value);
  }
  return name;
}

// All approximations for speed together.
void for_speed(ViewOptions* options) {
  options->distance_maps = 1;
  options->second_side = SecondSide::kFaded;
}

// The approximations that are hardly visible together.
void for_balance(ViewOptions* options) {
  options->distance_maps = 2;
  options->second_side = SecondSide::kFaded;
}

void for_accuracy(ViewOptions* options) {
  options->interpolation = Interpolation::kCubic;
  options->stations_mixed = 8;
}

void for_accuracy_faded(ViewOptions* options) {
  for_accuracy(options);
  options->second_side = SecondSide::kFaded;
}

// Collects variations of the central settings without duplicates.
class Sweep {
 public:
  explicit Sweep(const SweepBase& base) : base_(base) {
    for (const ViewMode& mode : base.centres) {
      TradeSetting centre{.mode = mode, .threads = base.threads};
      centre.mode.options.width = base.width_px;
      centre.name = generation_name(mode.options.generation);
      settings_.push_back(centre);
    }
    centres_ = settings_;
  }

  // Adds the central setting of a generation, where the room supports it, changed by `change`.
  template <typename Change>
  void add(Generation generation, const Change& change) {
    for (const TradeSetting& centre : centres_) {
      if (centre.mode.options.generation != generation) continue;
      TradeSetting setting = centre;
      change(&setting);
      finish(centre, std::move(setting));
    }
  }

  std::vector<TradeSetting> take() { return std::move(settings_); }

 private:
  void finish(const TradeSetting& centre, TradeSetting setting) {
    ViewOptions& options = setting.mode.options;
    for (const Dial& dial : kDials) {
      if (has_effect(dial, options, base_.stored_width_px)) continue;
      dial.value.set(&options, dial.value.get(centre.mode.options));
    }
    if (options.k_deg != centre.mode.options.k_deg) {
      setting.mode.connection = connection_name(options.k_deg);
      setting.mode.k_source = "as swept";
    }
    setting.name = name_of(setting, centre);
    const bool known = std::ranges::any_of(settings_, [&](const TradeSetting& other) {
      return parameters_of(other) == parameters_of(setting);
    });
    if (!known) settings_.push_back(std::move(setting));
  }

  const SweepBase& base_;
  std::vector<TradeSetting> centres_;
  std::vector<TradeSetting> settings_;
};

}  // namespace

ordered_json parameters_of(const TradeSetting& setting) {
  ordered_json parameters = swept_dials_json(setting.mode.options);
  parameters["threads"] = setting.threads;
  return parameters;
}

std::vector<TradeSetting> trade_sweep(const SweepBase& base) {
  Sweep sweep(base);
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    const Generation generation =
        dial.effect == DialEffect::kTwoSidedViews ? Generation::kTwoSided : Generation::kHlfVd;
    for (const double value : dial.sweep->values) {
      sweep.add(generation, [&](TradeSetting* setting) {
        dial.value.set(&setting->mode.options,
                       dial.sweep->of_truth_width ? width_of_share(base.width_px, value) : value);
      });
    }
  }
  sweep.add(Generation::kHlfVd, [](TradeSetting* setting) { setting->threads = 1; });
  for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
    for (const auto change : {for_speed, for_balance, for_accuracy, for_accuracy_faded}) {
      sweep.add(generation, [&](TradeSetting* setting) { change(&setting->mode.options); });
    }
  }
  return sweep.take();
}

}  // namespace raywalk
