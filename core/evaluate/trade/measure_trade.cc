// The settings of a trade, one after another, kept for a run that resumes.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/evaluate/trade/trade.h"
#include "core/evaluate/trade/trade_json.h"
#include "core/evaluate/validation/validate.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/fingerprint.h"
#include "core/files/json_text.h"
#include "core/files/sha256.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Everything that measurements depend on, except the settings.
std::string inputs_sha256(const TradeInput& input) {
  std::string text =
      fmt::format("{} {} {} {}\n{}\n", input.repetitions, thread_count(), input.connect_viewpoints,
                  cpu_name(), room_fingerprint(*input.room));
  for (const TradeView& view : input.views) {
    text += fmt::format("{} {} {} {} {} {}\n", view.name, view.viewpoint.x_m,
                        view.height_m.value_or(0.0), view.viewpoint.z_m,
                        sha256_of_pixels(view.truth), sha256_of_pixels(view.mask));
  }
  return sha256_hex(text);
}

// The finished settings of an unfinished trade, by their parameters.
class KeptSettings {
 public:
  KeptSettings(fs::path file, std::string inputs)
      : file_(std::move(file)), inputs_(std::move(inputs)) {
    const AtomicFile probe(file_);
    if (!fs::exists(file_)) return;
    const CheckedJson kept = CheckedJson::read(file_, "remove it, and everything is measured");
    if (kept.at("inputs").text() != inputs_) {
      throw Error(file_.string() +
                  " belongs to another room, truth or machine; remove it, or use another --report");
    }
    for (const CheckedJson& setting : kept.at("settings").items()) {
      kept_[setting.at("parameters").text()] = measurement_from(setting.at("measured"));
    }
  }

  const TradeMeasurement* find(const TradeSetting& setting) const {
    const auto found = kept_.find(parameters_of(setting).dump());
    return found == kept_.end() ? nullptr : &found->second;
  }

  void add(const TradeSetting& setting, const TradeMeasurement& measured) {
    kept_[parameters_of(setting).dump()] = measured;
    ordered_json document{{"inputs", inputs_}, {"settings", ordered_json::array()}};
    for (const auto& [parameters, measurement] : kept_) {
      document["settings"].push_back(
          {{"parameters", parameters}, {"measured", json_of(measurement)}});
    }
    write_file_atomically(file_, json_text(document));
  }

 private:
  fs::path file_;
  std::string inputs_;
  std::map<std::string, TradeMeasurement> kept_;
};

// The connection error at each generation and k of the settings; the other parameters hardly change
// it.
void find_connections(const TradeInput& input, std::vector<MeasuredSetting>* settings) {
  std::vector<ViewMode> modes;
  std::set<double> k_list_deg;
  for (const TradeSetting& setting : input.settings) {
    k_list_deg.insert(setting.mode.options.k_deg);
    const bool known = std::ranges::any_of(modes, [&](const ViewMode& other) {
      return other.options.generation == setting.mode.options.generation;
    });
    if (!known) modes.push_back(setting.mode);
  }
  const ConnectErrorOptions options{.viewpoints = input.connect_viewpoints,
                                    .k_list_deg = {k_list_deg.begin(), k_list_deg.end()}};
  for (const ConnectError& error : connection_errors(*input.room, modes, options)) {
    // Settings of unlike k are only comparable over the corners that all of these k can read.
    if (!(error.common_share >= kLeastCommonShare)) continue;
    for (MeasuredSetting& setting : *settings) {
      const ViewOptions& view = setting.setting.mode.options;
      for (const ConnectErrorRow& row : error.rows) {
        if (view.generation != row.generation || view.k_deg != row.k_deg) continue;
        setting.e_connect = row.e_connect_common;
      }
    }
  }
}

void find_front(std::vector<MeasuredSetting>* settings) {
  for (MeasuredSetting& setting : *settings) {
    const double ratio = setting.measured.time.ratio, psnr_db = setting.measured.scores.psnr_db;
    setting.on_front = std::ranges::none_of(*settings, [&](const MeasuredSetting& other) {
      const double other_ratio = other.measured.time.ratio;
      const double other_db = other.measured.scores.psnr_db;
      return other_ratio <= ratio && other_db >= psnr_db &&
             (other_ratio < ratio || other_db > psnr_db);
    });
  }
}

}  // namespace

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::vector<MeasuredSetting> measure_trade(const TradeInput& input, const fs::path& partial) {
  KeptSettings kept(partial, inputs_sha256(input));
  const auto left = std::ranges::count_if(
      input.settings, [&](const TradeSetting& setting) { return kept.find(setting) == nullptr; });
  PitchRemap yardstick(input.views.front().truth.cols);
  const ViewTimer timer{input.repetitions, &yardstick, input.time_source};
  std::vector<MeasuredSetting> settings;
  {
    Progress progress("trade", left, "settings");
    for (const TradeSetting& setting : input.settings) {
      settings.push_back({.setting = setting});
      if (const TradeMeasurement* found = kept.find(setting)) {
        settings.back().measured = *found;
        continue;
      }
      settings.back().measured = measure_setting(setting, input.views, timer);
      kept.add(setting, settings.back().measured);
      progress.advance();
    }
  }
  find_connections(input, &settings);
  find_front(&settings);
  return settings;
}

}  // namespace raywalk
