#include "calibrate/stitch/stitch_record.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

constexpr int kStitchVersion = 1;
constexpr int kLightStep_deg = 5;
constexpr int kWidestLight_deg = 95;

// The falloff that is corrected.
ordered_json light_json(const LensBalance& balance) {
  ordered_json light = ordered_json::array();
  for (int angle_deg = 0; angle_deg <= kWidestLight_deg; angle_deg += kLightStep_deg) {
    light.push_back(
        {{"angle_deg", angle_deg}, {"share", balance.share_at(radians_from_degrees(angle_deg))}});
  }
  return light;
}

ordered_json balance_json(const BalanceReport& report) {
  const BalanceFit& fit = report.fit;
  const auto& bgr = fit.balance.back_gain;
  return {{"back_gain", {bgr[2], bgr[1], bgr[0]}},
          {"falloff_2", fit.balance.falloff_2},
          {"falloff_4", fit.balance.falloff_4},
          {"gain_sigma", fit.gain_sigma},
          {"share_45", fit.balance.share_at(0.25 * kPi)},
          {"share_45_sigma", fit.share_45_sigma},
          {"share_90", fit.balance.share_at(kHalfPi)},
          {"share_90_sigma", fit.share_90_sigma},
          {"scatter", fit.scatter},
          {"frames", report.frames},
          {"overlap_ratios", report.overlap_ratios},
          {"motion_ratios", report.motion_ratios},
          {"light", light_json(fit.balance)}};
}

BalanceReport balance_from(const CheckedJson& json) {
  BalanceReport report;
  BalanceFit& fit = report.fit;
  const CheckedJson balance = json.at("balance");
  const std::vector<CheckedJson> back_gain = balance.at("back_gain").items(3);
  for (std::size_t colour = 0; colour < 3; ++colour) {
    fit.balance.back_gain[colour] = back_gain[2 - colour].number();
  }
  fit.balance.falloff_2 = balance.at("falloff_2").number();
  fit.balance.falloff_4 = balance.at("falloff_4").number();
  fit.gain_sigma = balance.at("gain_sigma").number();
  fit.share_45_sigma = balance.at("share_45_sigma").number();
  fit.share_90_sigma = balance.at("share_90_sigma").number();
  fit.scatter = balance.at("scatter").number();
  report.frames = balance.at("frames").integer(0);
  report.overlap_ratios = balance.at("overlap_ratios").integer(0);
  report.motion_ratios = balance.at("motion_ratios").integer(0);
  fit.ratios = report.overlap_ratios + report.motion_ratios;
  report.step_before_levels = json.at("seam").at("step_before_levels").number();
  report.step_after_levels = json.at("seam").at("step_after_levels").number();
  report.correlation = json.at("seam").at("correlation").number();
  report.warnings = json.at("warnings").texts();
  return report;
}

StitchRecord record_from(const CheckedJson& json) {
  StitchRecord record;
  record.fingerprint = json.at("fingerprint").text();
  record.complete = json.at("complete").boolean();
  record.panorama = {json.at("width_px").integer(0), json.at("height_px").integer(0)};
  record.frames = json.at("frames").integer(0);
  record.options.blend = blend_method_named(json.at("blend").text());
  record.options.blend_deg = json.at("blend_deg").number();
  const CheckedJson distance = json.at("seam_distance_m");
  if (!distance.is_null()) record.options.seam_distance_m = distance.number();
  record.balance = balance_from(json);
  return record;
}

}  // namespace

ordered_json stitch_document(const StitchRecord& record) {
  const double distance = record.options.seam_distance_m;
  ordered_json document{{"format_version", kStitchVersion},
                        {"fingerprint", record.fingerprint},
                        {"complete", record.complete},
                        {"width_px", record.panorama.width},
                        {"height_px", record.panorama.height},
                        {"frames", record.frames},
                        {"blend", name_of(record.options.blend)},
                        {"blend_deg", record.options.blend_deg},
                        {"seam_distance_m", nullptr},
                        {"balance", balance_json(record.balance)},
                        {"seam",
                         {{"step_before_levels", record.balance.step_before_levels},
                          {"step_after_levels", record.balance.step_after_levels},
                          {"correlation", record.balance.correlation}}},
                        {"warnings", record.balance.warnings}};
  if (std::isfinite(distance)) document["seam_distance_m"] = distance;
  return document;
}

std::optional<StitchRecord> read_stitch_record(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const CheckedJson json = CheckedJson::read(file);
    if (json.at("format_version").integer() != kStitchVersion) return std::nullopt;
    return record_from(json);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string name_of(BlendMethod method) {
  return method == BlendMethod::kMultiBand ? "multi-band" : "feather";
}

BlendMethod blend_method_named(const std::string& name) {
  for (const BlendMethod method : {BlendMethod::kMultiBand, BlendMethod::kFeather}) {
    if (name == name_of(method)) return method;
  }
  throw UsageError("unknown blend " + excerpt(name) + "; use multi-band or feather");
}

}  // namespace raywalk::calibrate
