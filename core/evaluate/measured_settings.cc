#include "core/evaluate/measured_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 3;
constexpr const char* kAdvice = "measure again with raywalk-render trade";

// What json_of() wrote, also refusing the width 0.
double value_from(const ViewParameter& parameter, const CheckedJson& json) {
  const bool is_choice = parameter.value.kind == ParameterKind::kChoice;
  const std::string text = is_choice ? json.text() : fmt::format("{}", json.number());
  try {
    const double value = value_of(parameter, text);
    if (value >= parameter.least) return value;
    throw std::invalid_argument(fmt::format("must be at least {:g}", parameter.least));
  } catch (const std::invalid_argument& error) {
    json.fail(fmt::format("{} {}", excerpt(text), error.what()));
  }
}

MeasuredChoice choice_from(const CheckedJson& json) {
  constexpr double kMostRatio = 1e9;  // a damaged file is not believed
  MeasuredChoice choice{.name = json.at("name").text(),
                        .ratio = json.at("ratio").number(0.0, kMostRatio),
                        .psnr_db = json.at("psnr_db").number(0.0, kMostPsnr_db)};
  for (const ViewParameter& parameter : kViewParameters) {
    if (parameter.sweep)
      parameter.value.set(&choice.options, value_from(parameter, json.at(parameter.key)));
  }
  return choice;
}

}  // namespace

ordered_json json_of(const ViewParameter& parameter, const ViewOptions& options) {
  const double value = parameter.value.get(options);
  if (parameter.value.kind == ParameterKind::kChoice) return text_of(parameter, value);
  if (parameter.value.kind == ParameterKind::kInteger) return static_cast<int>(value);
  return value;
}

ordered_json swept_parameters_json(const ViewOptions& options) {
  ordered_json json;
  for (const ViewParameter& parameter : kViewParameters) {
    if (parameter.sweep) json[parameter.key] = json_of(parameter, options);
  }
  return json;
}

fs::path measured_settings_path(const fs::path& room) { return room / "measured.json"; }

void write_measured_settings(const fs::path& room, const MeasuredSettings& measured) {
  ordered_json json{{"format", "raywalk-measured-settings"},
                    {"format_version", kFormatVersion},
                    {"distances_sha256", measured.distances_sha256},
                    {"width_px", measured.width_px},
                    {"settings", ordered_json::array()}};
  for (const MeasuredChoice& choice : measured.choices) {
    ordered_json setting{{"name", choice.name}};
    setting.update(swept_parameters_json(choice.options));
    setting.update(ordered_json{{"ratio", choice.ratio}, {"psnr_db", choice.psnr_db}});
    json["settings"].push_back(setting);
  }
  write_file_atomically(measured_settings_path(room), json_text(json));
}

std::optional<MeasuredSettings> read_measured_settings(const fs::path& room) {
  const fs::path file = measured_settings_path(room);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const CheckedJson root = CheckedJson::read(file, kAdvice);
  root.require_version(kFormatVersion);
  MeasuredSettings measured{
      .distances_sha256 = root.at("distances_sha256").text(),
      .width_px = static_cast<int>(value_from(parameter_of("width_px"), root.at("width_px")))};
  for (const CheckedJson& setting : root.at("settings").items()) {
    measured.choices.push_back(choice_from(setting));
  }
  if (measured.choices.empty()) root.fail("holds no setting of its own room");
  return measured;
}

}  // namespace raywalk
