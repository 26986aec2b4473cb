#include "core/evaluate/trade/trade_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/room/requirements.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr int kTradeFormatVersion = 5;

// Of the parameters that are dials.
ordered_json parameters_json() {
  ordered_json json = ordered_json::array();
  for (const Dial& dial : kDials) {
    if (!dial.sweep) continue;
    json.push_back({{"key", dial.key},
                    {"help", dial.help},
                    {"values", values_text(dial)},
                    {"default", text_of(dial, default_of(dial))},
                    {"cost", dial.cost}});
  }
  return json;
}

ordered_json json_of(const MeasuredSetting& setting, std::size_t number) {
  ordered_json json{{"number", number}, {"name", setting.setting.name}};
  json.update(parameters_of(setting.setting));
  json.update(json_of(setting.measured));
  json["e_connect"] = setting.e_connect;  // NaN becomes null when the text is written
  json["on_front"] = setting.on_front;
  return json;
}

std::string csv_field(const ordered_json& value) {
  if (value.is_null() || (value.is_number_float() && std::isnan(value.get<double>()))) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (!value.is_string()) return value.dump();
  std::string quoted = "\"";
  for (const char c : value.get<std::string>()) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

template <typename Member>
double median_of(std::span<const MeasuredSetting> settings, Member member) {
  std::vector<double> values;
  for (const MeasuredSetting& setting : settings) values.push_back(setting.measured.time.*member);
  return median(values);
}

}  // namespace

ordered_json json_of(const TradeMeasurement& measured) {
  return {{"ms", measured.time.ms},
          {"ratio", measured.time.ratio},
          {"remap_ms", measured.time.remap_ms},
          {"remap_spread", measured.time.remap_spread},
          {"psnr_db", measured.scores.psnr_db},
          {"ws_psnr_db", measured.scores.ws_psnr_db},
          {"ssim", measured.scores.ssim},
          {"fsim", measured.scores.fsim}};
}

TradeMeasurement measurement_from(const CheckedJson& json) {
  constexpr double kMost = 1e9;  // a damaged file is not believed
  const auto number = [&](const char* key, double least, double most) {
    return json.at(key).number(least, most);
  };
  return {.time = {.ms = number("ms", 0.0, kMost),
                   .ratio = number("ratio", 0.0, kMost),
                   .remap_ms = number("remap_ms", 0.0, kMost),
                   .remap_spread = number("remap_spread", 0.0, kMost)},
          .scores = {.psnr_db = number("psnr_db", -1.0, kMaxPsnrDb),
                     .ws_psnr_db = number("ws_psnr_db", -1.0, kMaxPsnrDb),
                     .ssim = number("ssim", -1.0, 1.0),
                     .fsim = number("fsim", -1.0, 1.0)}};
}

ordered_json trade_document(const TradeInput& input, std::span<const MeasuredSetting> settings) {
  ordered_json json{{"format", "raywalk-trade"},
                    {"format_version", kTradeFormatVersion},
                    {"written_by", "raywalk " RAYWALK_VERSION},
                    {"room", input.room->directory().string()},
                    {"stored_width_px", input.room->panorama().width},
                    {"distances", input.room->distances_origin()},
                    {"distances_sha256", distances_sha256(*input.room)},
                    {"truth", input.truth},
                    {"machine", {{"threads", thread_count()}, {"cpu", cpu_name()}}},
                    {"width_px", input.views.front().truth.cols},
                    {"remap_ms", median_of(settings, &ViewTime::remap_ms)},
                    {"repetitions", input.repetitions},
                    {"busy", median_of(settings, &ViewTime::remap_spread) > kBusySpread},
                    {"connect_viewpoints", input.connect_viewpoints},
                    {"views", ordered_json::array()},
                    {"pictured_view", input.views[pictured_view(input.views.size())].name},
                    {"parameters", parameters_json()},
                    {"presets", ordered_json::array()},
                    {"settings", ordered_json::array()}};
  for (const TradeView& view : input.views) json["views"].push_back(view.name);
  for (const NamedMode& preset : input.presets) {
    const auto measured = std::ranges::find_if(settings, [&](const MeasuredSetting& setting) {
      TradeSetting same = setting.setting;
      same.mode = preset.mode;
      same.mode.options.width = setting.setting.mode.options.width;
      return same.threads == thread_count() &&
             parameters_of(same) == parameters_of(setting.setting);
    });
    json["presets"].push_back({{"name", preset.name},
                               {"number", measured - settings.begin() + 1},
                               {"reason", preset.reason}});
  }
  for (std::size_t i = 0; i < settings.size(); ++i) {
    json["settings"].push_back(json_of(settings[i], i + 1));
  }
  return json;
}

std::string trade_csv(const ordered_json& document) {
  std::string text;
  for (const ordered_json& setting : document["settings"]) {
    std::string header, row;
    for (const auto& [key, value] : setting.items()) {
      header += (header.empty() ? "" : ",") + key;
      row += (row.empty() ? "" : ",") + csv_field(value);
    }
    if (text.empty()) text = header + "\n";
    text += row + "\n";
  }
  return text;
}

}  // namespace raywalk
