#include "core/evaluate/trade/measured_settings.h"

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/evaluate/trade/dial_json.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/json_text.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 3;
constexpr const char* kAdvice = "measure again with raywalk-render trade";

ordered_json json_of(const MeasuredChoice& choice) {
  ordered_json json{{"name", choice.name}};
  json.update(swept_dials_json(choice.options));
  json.update(ordered_json{{"ratio", choice.ratio}, {"psnr_db", choice.psnr_db}});
  return json;
}

MeasuredChoice choice_from(const CheckedJson& json) {
  constexpr double kMostRatio = 1e9;  // a damaged file is not believed
  return {.name = json.at("name").text(),
          .options = options_from(json),
          .ratio = json.at("ratio").number(0.0, kMostRatio),
          .psnr_db = json.at("psnr_db").number(0.0, kMostPsnr_db)};
}

MeasuredSettings settings_from(const CheckedJson& root) {
  root.require_version(kFormatVersion);
  MeasuredSettings measured{
      .distances_sha256 = root.at("distances_sha256").text(),
      .width_px = static_cast<int>(value_from(dial_of("width_px"), root.at("width_px")))};
  for (const CheckedJson& setting : root.at("settings").items()) {
    measured.choices.push_back(choice_from(setting));
  }
  return measured;
}

}  // namespace

fs::path measured_settings_path(const fs::path& room) { return room / "measured.json"; }

void write_measured_settings(const fs::path& room, const MeasuredSettings& measured) {
  ordered_json json{{"format", "raywalk-measured-settings"},
                    {"format_version", kFormatVersion},
                    {"distances_sha256", measured.distances_sha256},
                    {"width_px", measured.width_px}};
  json["settings"] = ordered_json::array();
  for (const MeasuredChoice& choice : measured.choices) json["settings"].push_back(json_of(choice));
  write_file_atomically(measured_settings_path(room), json_text(json));
}

std::optional<StoredMeasurement> read_measured_settings(const fs::path& room) {
  fs::path file = measured_settings_path(room);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const CheckedJson root = CheckedJson::read(file, kAdvice);
  MeasuredSettings settings = settings_from(root);
  if (settings.choices.empty()) root.fail("holds no setting of its own room");
  return StoredMeasurement{std::move(file), std::move(settings)};
}

}  // namespace raywalk
