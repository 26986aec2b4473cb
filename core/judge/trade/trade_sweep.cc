#include "core/judge/trade/trade_sweep.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "core/room/connection_errors.h"

namespace raywalk {
namespace {

using Settings = std::vector<TradeSetting>;
using Move = std::function<void(ViewOptions*)>;

const std::vector<Generation> kCorrected{Generation::kHlfVd, Generation::kTwoSided};

// The valid picture width nearest to a share of another width.
int width_of_share(int width_px, double share) {
  return std::max(4, 4 * static_cast<int>(std::lround(share * width_px / 4.0)));
}

// Whether columns of an initial view lie between captured ones, so that they are interpolated.
bool resampled(const TradeSetting& setting) {
  const double fold =
      std::max(1.0, std::round(double(setting.stored_width_px) / setting.mode.options.width));
  return fold * setting.mode.options.width != setting.stored_width_px;
}

bool has_effect(const Dial& dial, const TradeSetting& setting) {
  const Generation generation = setting.mode.options.generation;
  switch (dial.effect) {
    case DialEffect::kAllViews:
      return true;
    case DialEffect::kSampledViews:
      return generation != Generation::kInitial || resampled(setting);
    case DialEffect::kCorrectedViews:
      return generation != Generation::kInitial;
    case DialEffect::kTwoSidedViews:
      return generation == Generation::kTwoSided;
  }
  return true;
}

// Sets dials without effect to their values in the central setting.
void reset_unused_dials(const ViewOptions& centre, TradeSetting* setting) {
  for (const Dial& dial : kDials) {
    if (has_effect(dial, *setting)) continue;
    dial.value.set(&setting->mode.options, dial.value.get(centre));
  }
}

// Collects settings without duplicates.
class Sweep {
 public:
  explicit Sweep(const SweepBase& base) : base_(base) {
    for (const ViewMode& mode : base.centres) centres_.push_back(centre(mode));
  }

  // The central settings of these generations, where the room supports them.
  Settings centres(const std::vector<Generation>& generations) const {
    Settings found;
    std::ranges::copy_if(centres_, std::back_inserter(found), [&](const TradeSetting& setting) {
      return std::ranges::count(generations, setting.mode.options.generation) > 0;
    });
    return found;
  }
  Settings centres() const { return centres_; }

  void add(TradeSetting setting) {
    const TradeSetting& centre = centre_of(setting);
    reset_unused_dials(centre.mode.options, &setting);
    const double k_deg = setting.mode.options.k_deg;
    if (k_deg != centre.mode.options.k_deg) {
      setting.mode.connection = connection_name(k_deg);
      setting.mode.k_source = "as swept";
    }
    setting.name = name_of(setting, centre);
    if (known_.insert(parameters_of(setting).dump()).second)
      settings_.push_back(std::move(setting));
  }
  void add(const Settings& settings) {
    for (const TradeSetting& setting : settings) add(setting);
  }
  void add(Generation generation, const Move& move) {
    for (TradeSetting setting : centres({generation})) {
      move(&setting.mode.options);
      add(std::move(setting));
    }
  }
  // Adds the same setting in another room, where that has the distances it needs.
  void add_in_room(std::size_t room, TradeSetting setting) {
    const TradeRoom& other = base_.rooms[room];
    const bool corrected = setting.mode.options.generation != Generation::kInitial;
    if (corrected && !other.room->has_distances()) return;
    setting.room = room;
    setting.stored_width_px = other.room->panorama().width;
    setting.depth = other.depth;
    setting.compression = other.room->compression();
    add(std::move(setting));
  }

  Settings take() { return std::move(settings_); }

 private:
  TradeSetting centre(const ViewMode& mode) const {
    TradeSetting setting{.mode = mode,
                         .threads = base_.threads,
                         .stored_width_px = base_.rooms.front().room->panorama().width,
                         .depth = base_.rooms.front().depth,
                         .compression = base_.rooms.front().room->compression()};
    setting.mode.options.width = base_.width_px;
    return setting;
  }
  const TradeSetting& centre_of(const TradeSetting& setting) const {
    return *std::ranges::find_if(centres_, [&](const TradeSetting& centre) {
      return centre.mode.options.generation == setting.mode.options.generation;
    });
  }

  const SweepBase& base_;
  Settings centres_;
  Settings settings_;
  std::set<std::string> known_;  // parameters of settings_
};

// Every setting with every value of a parameter.
template <typename T, typename Set>
Settings product(const Settings& settings, const std::vector<T>& values, const Set& set) {
  Settings all;
  for (const TradeSetting& setting : settings) {
    for (const T& value : values) {
      all.push_back(setting);
      set(&all.back(), value);
    }
  }
  return all;
}

// Every setting with every one of a dial's `values`.
Settings product(const SweepBase& base, const Settings& settings, const Dial& dial,
                 const DialValues& values) {
  const std::vector<double> list(values.begin(), values.end());
  return product(settings, list, [&](TradeSetting* setting, double value) {
    const double taken = dial.sweep->of_truth_width ? width_of_share(base.width_px, value) : value;
    dial.value.set(&setting->mode.options, taken);
  });
}

// Every dial alone, where it has an effect.
void add_single_moves(const SweepBase& base, Sweep* sweep) {
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    const Generation generation =
        dial.effect == DialEffect::kTwoSidedViews ? Generation::kTwoSided : Generation::kHlfVd;
    sweep->add(product(base, sweep->centres({generation}), dial, dial.sweep->singly));
  }
  for (TradeSetting setting : sweep->centres({Generation::kHlfVd})) {
    setting.threads = 1;
    sweep->add(std::move(setting));
  }
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

void add_combinations(Sweep* sweep) {
  for (const Generation generation : kCorrected) {
    sweep->add(generation, for_speed);
    sweep->add(generation, for_balance);
    sweep->add(generation, for_accuracy);
  }
  sweep->add(Generation::kTwoSided, [](ViewOptions* options) {
    for_accuracy(options);
    options->second_side = SecondSide::kFaded;
  });
}

void add_quick(const SweepBase& base, Sweep* sweep) {
  sweep->add(sweep->centres());
  add_single_moves(base, sweep);
  add_combinations(sweep);
  for (std::size_t room = 1; room < base.rooms.size(); ++room) {
    for (const TradeSetting& setting : sweep->centres()) sweep->add_in_room(room, setting);
  }
}

// All combinations of the values of a grid's dials, for every generation.
Settings grid_of(const SweepBase& base, const Sweep& sweep, DialGrid grid) {
  Settings settings = sweep.centres();
  for (const Dial& dial : kDials) {
    if (!dial.sweep || dial.sweep->grid != grid) continue;
    settings = product(base, settings, dial, dial.sweep->in_grid);
  }
  return settings;
}

void add_grids(const SweepBase& base, Sweep* sweep) {
  sweep->add(grid_of(base, *sweep, DialGrid::kSamples));
  sweep->add(product(grid_of(base, *sweep, DialGrid::kLayout), std::vector<int>{1, base.threads},
                     [](TradeSetting* setting, int threads) { setting->threads = threads; }));
}

void add_room_grid(const SweepBase& base, Sweep* sweep) {
  const Dial& dial = dial_of("interpolation");
  const Settings grid = product(base, sweep->centres(), dial, dial.sweep->in_grid);
  for (std::size_t room = 1; room < base.rooms.size(); ++room) {
    for (const TradeSetting& setting : grid) sweep->add_in_room(room, setting);
  }
}

}  // namespace

std::vector<TradeSetting> quick_sweep(const SweepBase& base) {
  Sweep sweep(base);
  add_quick(base, &sweep);
  return sweep.take();
}

std::vector<TradeSetting> full_sweep(const SweepBase& base) {
  Sweep sweep(base);
  add_quick(base, &sweep);
  add_grids(base, &sweep);
  add_room_grid(base, &sweep);
  return sweep.take();
}

}  // namespace raywalk
