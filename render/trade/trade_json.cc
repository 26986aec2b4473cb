#include "render/trade/trade_json.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace raywalk::render {
namespace {

using nlohmann::ordered_json;

constexpr int kTradeFormatVersion = 1;

ordered_json json_of(const TradeFronts& fronts) {
  return {{"psnr_db", fronts.psnr_db},
          {"ws_psnr_db", fronts.ws_psnr_db},
          {"ssim", fronts.ssim},
          {"fsim", fronts.fsim},
          {"e_connect", fronts.e_connect}};
}

ordered_json json_of(const MeasuredSetting& setting) {
  ordered_json json{{"name", setting.setting.name}};
  json.update(parameters_of(setting.setting));
  json.update(json_of(setting.measured));
  json["pareto"] = json_of(setting.pareto);
  return json;
}

ordered_json json_of(const RankAgreement& agreement) {
  const auto number = [](double value) {
    return std::isnan(value) ? ordered_json(nullptr) : ordered_json(value);
  };
  return {{"psnr_db", number(agreement.psnr_db)},
          {"ws_psnr_db", number(agreement.ws_psnr_db)},
          {"ssim", number(agreement.ssim)},
          {"fsim", number(agreement.fsim)}};
}

ordered_json json_of(const TradedRoom& room) {
  return {{"directory", room.directory},
          {"stored_width_px", room.stored_width_px},
          {"depth", room.depth}};
}

// A room's name may contain any bytes; invalid UTF-8 is replaced.
std::string text_of(const ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

std::string csv_field(const ordered_json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (!value.is_string()) return text_of(value, -1);
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

double number_or_nan(const ordered_json& value) {
  return value.is_null() ? std::nan("") : value.get<double>();
}

}  // namespace

ordered_json json_of(const TradeMeasurement& measured) {
  const auto held_out = [&](double ViewScores::*score) {
    return measured.held_out ? ordered_json((*measured.held_out).*score) : nullptr;
  };
  // nlohmann::json turns NaN into null only when the text is written.
  return {
      {"ms", measured.ms},
      {"ratio", measured.ratio},
      {"cpu_ratio", measured.cpu_ratio},
      {"remap_ms", measured.remap_ms},
      {"peak_mb", measured.peak_mb},
      {"mapped_mb", measured.mapped_mb},
      {"touched_mb", measured.touched_mb ? ordered_json(*measured.touched_mb) : nullptr},
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

TradeMeasurement measurement_from(const ordered_json& json) {
  TradeMeasurement measured{.ms = json.at("ms").get<double>(),
                            .ratio = json.at("ratio").get<double>(),
                            .cpu_ratio = json.at("cpu_ratio").get<double>(),
                            .remap_ms = json.at("remap_ms").get<double>(),
                            .peak_mb = json.at("peak_mb").get<double>(),
                            .mapped_mb = json.at("mapped_mb").get<double>(),
                            .scores = {.psnr_db = json.at("psnr_db").get<double>(),
                                       .ws_psnr_db = json.at("ws_psnr_db").get<double>(),
                                       .ssim = json.at("ssim").get<double>(),
                                       .fsim = json.at("fsim").get<double>()},
                            .e_connect = number_or_nan(json.at("e_connect"))};
  if (!json.at("touched_mb").is_null()) measured.touched_mb = json.at("touched_mb").get<double>();
  if (!json.at("held_out_psnr_db").is_null()) {
    measured.held_out = {.psnr_db = json.at("held_out_psnr_db").get<double>(),
                         .ws_psnr_db = json.at("held_out_ws_psnr_db").get<double>(),
                         .ssim = json.at("held_out_ssim").get<double>(),
                         .fsim = json.at("held_out_fsim").get<double>()};
  }
  return measured;
}

std::string trade_json(const Trade& trade) {
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
                    {"connect_viewpoints", trade.connect_viewpoints},
                    {"views", trade.views},
                    {"held_out_views", trade.held_out_views},
                    {"distances_sha256", trade.distances_sha256}};
  json["rank_correlation"] = trade.held_out_views.empty() ? ordered_json(nullptr)
                                                          : json_of(rank_agreement(trade.settings));
  json["presets"] = ordered_json::array();
  for (const TradedPreset& preset : trade.presets) {
    json["presets"].push_back({{"name", preset.name},
                               {"setting", trade.settings[preset.setting].setting.name},
                               {"reason", preset.reason}});
  }
  json["rooms"] = ordered_json::array();
  for (const TradedRoom& room : trade.rooms) json["rooms"].push_back(json_of(room));
  json["settings"] = ordered_json::array();
  for (const MeasuredSetting& setting : trade.settings) {
    json["settings"].push_back(json_of(setting));
  }
  return text_of(json, 2) + "\n";
}

std::string trade_csv(const Trade& trade) {
  std::string text;
  for (const MeasuredSetting& setting : trade.settings) {
    std::string header, row;
    const ordered_json fields = flattened(json_of(setting));
    for (const auto& [key, value] : fields.items()) {
      header += (header.empty() ? "" : ",") + key;
      row += (row.empty() ? "" : ",") + csv_field(value);
    }
    if (text.empty()) text = header + "\n";
    text += row + "\n";
  }
  return text;
}

}  // namespace raywalk::render
