#include "core/judge/trade/trade_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const TradeFronts& fronts) {
  return {{"psnr_db", fronts.psnr_db},
          {"ws_psnr_db", fronts.ws_psnr_db},
          {"ssim", fronts.ssim},
          {"fsim", fronts.fsim},
          {"e_connect", fronts.e_connect}};
}

ordered_json json_of(const Trade& trade, const MeasuredSetting& setting) {
  ordered_json json{{"name", setting.setting.name}};
  json.update(parameters_of(setting.setting));
  json["rays_mb"] = trade.rooms[setting.setting.room].rays_mb;
  json.update(json_of(setting.measured));
  json["pareto"] = json_of(setting.pareto);
  return json;
}

ordered_json json_of(const RankAgreement& agreement) {
  return {{"psnr_db", agreement.psnr_db},
          {"ws_psnr_db", agreement.ws_psnr_db},
          {"ssim", agreement.ssim},
          {"fsim", agreement.fsim}};
}

ordered_json json_of(const TradedRoom& room) {
  return {{"directory", room.directory},
          {"stored_width_px", room.stored_width_px},
          {"depth", room.depth},
          {"compression", room.compression},
          {"rays_mb", room.rays_mb}};
}

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

std::string csv_field(const ordered_json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (!value.is_string()) return value.dump();
  std::string quoted = "\"";
  for (const char c : value.get<std::string>()) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

// The setting without nesting: pareto.ssim becomes pareto_ssim.
ordered_json flattened(const ordered_json& setting) {
  ordered_json flat;
  for (const auto& [key, value] : setting.items()) {
    if (!value.is_object()) {
      flat[key] = value;
      continue;
    }
    for (const auto& [inner, inner_value] : value.items()) {
      flat[fmt::format("{}_{}", key, inner)] = inner_value;
    }
  }
  return flat;
}

// The fastest and slowest view that anyone measures, and the largest volume of data; both only keep
// damaged files from being believed.
constexpr double kMostMs = 1e9;
constexpr double kMostMb = 1e9;

ViewTime time_from(const CheckedJson& json) {
  return {.ms = json.at("ms").number(0.0, kMostMs),
          .ratio = json.at("ratio").number(0.0, kMostMs),
          .cpu_ratio = json.at("cpu_ratio").number(0.0, kMostMs),
          .remap_ms = json.at("remap_ms").number(0.0, kMostMs),
          .remap_spread = json.at("remap_spread").number(0.0),
          .others_share = json.at("others_share").number(0.0, 1.0)};
}

ViewScores scores_from(const CheckedJson& json, const std::string& prefix) {
  const auto score = [&](const char* key, double most) {
    return json.at(prefix + key).number(-1.0, most);
  };
  return {.psnr_db = score("psnr_db", kMaxPsnrDb),
          .ws_psnr_db = score("ws_psnr_db", kMaxPsnrDb),
          .ssim = score("ssim", 1.0),
          .fsim = score("fsim", 1.0)};
}

}  // namespace

ordered_json json_of(const TradeMeasurement& measured) {
  const auto held_out = [&](double ViewScores::*score) {
    return measured.held_out ? ordered_json((*measured.held_out).*score) : nullptr;
  };
  // nlohmann::json turns NaN into null only when the text is written.
  return {
      {"ms", measured.time.ms},
      {"ratio", measured.time.ratio},
      {"cpu_ratio", measured.time.cpu_ratio},
      {"remap_ms", measured.time.remap_ms},
      {"remap_spread", measured.time.remap_spread},
      {"others_share", measured.time.others_share},
      {"disturbed", measured.disturbed},
      {"peak_mb", measured.peak_mb},
      {"mapped_mb", measured.mapped_mb},
      {"psnr_db", measured.scores.psnr_db},
      {"ws_psnr_db", measured.scores.ws_psnr_db},
      {"ssim", measured.scores.ssim},
      {"fsim", measured.scores.fsim},
      {"held_out_psnr_db", held_out(&ViewScores::psnr_db)},
      {"held_out_ws_psnr_db", held_out(&ViewScores::ws_psnr_db)},
      {"held_out_ssim", held_out(&ViewScores::ssim)},
      {"held_out_fsim", held_out(&ViewScores::fsim)},
      {"e_connect", std::isnan(measured.e_connect) ? nullptr : ordered_json(measured.e_connect)}};
}

TradeMeasurement measurement_from(const CheckedJson& json) {
  TradeMeasurement measured{.time = time_from(json),
                            .disturbed = json.at("disturbed").boolean(),
                            .peak_mb = json.at("peak_mb").number(-kMostMb, kMostMb),
                            .mapped_mb = json.at("mapped_mb").number(-kMostMb, kMostMb),
                            .scores = scores_from(json, ""),
                            .e_connect = json.at("e_connect").number_or(std::nan(""))};
  if (!json.at("held_out_psnr_db").is_null()) measured.held_out = scores_from(json, "held_out_");
  return measured;
}

ordered_json trade_document(const Trade& trade) {
  ordered_json json{{"format", "raywalk-trade"},
                    {"format_version", kTradeFormatVersion},
                    {"written_by", "raywalk " RAYWALK_VERSION},
                    {"room", trade.rooms.front().directory},
                    {"truth", trade.truth},
                    {"sweep", trade.sweep},
                    {"machine", {{"threads", trade.threads}, {"cpu", trade.cpu}}},
                    {"width_px", trade.width_px},
                    {"remap_ms", trade.remap_ms},
                    {"repetitions", trade.repetitions},
                    {"disturbed_settings", disturbed_count(trade.settings)},
                    {"connect_viewpoints", trade.connect_viewpoints},
                    {"views", trade.views},
                    {"pictured_view", trade.views[pictured_view(trade.views.size())]},
                    {"held_out_views", trade.held_out_views},
                    {"distances_sha256", trade.distances_sha256},
                    {"parameters", parameters_json()}};
  json["rank_correlation"] = trade.held_out_views.empty() ? ordered_json(nullptr)
                                                          : json_of(rank_agreement(trade.settings));
  json["presets"] = ordered_json::array();
  for (const TradedPreset& preset : trade.presets) {
    json["presets"].push_back(
        {{"name", preset.name}, {"number", preset.setting + 1}, {"reason", preset.reason}});
  }
  json["rooms"] = ordered_json::array();
  for (const TradedRoom& room : trade.rooms) json["rooms"].push_back(json_of(room));
  json["settings"] = ordered_json::array();
  for (const MeasuredSetting& setting : trade.settings) {
    ordered_json numbered{{"number", json["settings"].size() + 1}};
    numbered.update(json_of(trade, setting));
    json["settings"].push_back(numbered);
  }
  return json;
}

std::string trade_csv(const Trade& trade) {
  std::string text;
  for (const MeasuredSetting& setting : trade.settings) {
    std::string header, row;
    const ordered_json fields = flattened(json_of(trade, setting));
    for (const auto& [key, value] : fields.items()) {
      header += (header.empty() ? "" : ",") + key;
      row += (row.empty() ? "" : ",") + csv_field(value);
    }
    if (text.empty()) text = header + "\n";
    text += row + "\n";
  }
  return text;
}

}  // namespace raywalk
