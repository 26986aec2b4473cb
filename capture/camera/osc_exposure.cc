#include "capture/camera/osc_exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "capture/base/device_fault.h"
#include "capture/camera/osc_client.h"
#include "core/files/exif.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr int kManual = 1;                    // exposureProgram
constexpr double kHeldTolerance_ev = 0.029;   // 2 %: 0.01666666 for 1/60
constexpr double kExifTolerance_ev = 0.2;     // a camera's steps are 1/3 EV
constexpr double kTemperatureStep_k = 100.0;  // Theta: 2500 to 10000 "in 100-Kelvin units"
constexpr double kLargestTemperature_k = 100000.0;
constexpr const char* kByTemperature = "_colorTemperature";

// The number in the list `<name>Support` that is least distant from `wanted`; `wanted` itself if
// there is none at a finite distance.
double nearest(const Json& options, const std::string& name, double wanted,
               double (*distance)(double, double)) {
  double best = wanted;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const Json& value : list_at(options, name + "Support")) {
    if (!value.is_number()) continue;
    const double away = distance(value.get<double>(), wanted);
    if (!(away < best_distance)) continue;
    best = value.get<double>();
    best_distance = away;
  }
  return best;
}

// Cameras expect whole numbers for iso.
Json number(double value) {
  const double whole = std::round(value);
  const bool is_whole = whole == value && std::abs(value) < 1e9;
  return is_whole ? Json(static_cast<std::int64_t>(whole)) : Json(value);
}

Json white_balance_options(int wanted_k, const Json& options) {
  const Json choices = list_at(options, "whiteBalanceSupport");
  if (options.contains(kByTemperature) ||
      std::find(choices.begin(), choices.end(), kByTemperature) != choices.end()) {
    const double present_k = number_at(options, kByTemperature).value_or(0.0);
    const double chosen_k = wanted_k > 0 ? wanted_k : present_k;
    if (chosen_k > 0.0 && chosen_k <= kLargestTemperature_k) {
      const auto rounded =
          std::llround(chosen_k / kTemperatureStep_k) * static_cast<int>(kTemperatureStep_k);
      return {{"whiteBalance", kByTemperature}, {kByTemperature, rounded}};
    }
  }
  if (wanted_k > 0) {
    throw DeviceFault(FaultKind::kExposure,
                      fmt::format("the camera cannot be set to a white balance of {} K; set "
                                  "camera.exposure.white_balance_k to 0",
                                  wanted_k));
  }
  return {{"whiteBalance", "daylight"}};
}

std::string shown(const Json& value) { return value.is_null() ? "unknown" : value.dump(); }

// The first option of `set` that differs in `held` by more than the tolerance of numbers in EV.
std::string difference(const Json& set, const Json& held, double tolerance_ev) {
  for (const auto& [name, value] : set.items()) {
    const Json present = held.value(name, Json());
    if (present == value) continue;
    const bool are_numbers = value.is_number() && present.is_number();
    if (are_numbers &&
        std::abs(std::log2(present.get<double>() / value.get<double>())) <= tolerance_ev) {
      continue;
    }
    return fmt::format("{} is {} instead of {}", name, shown(present), shown(value));
  }
  return {};
}

}  // namespace

std::optional<ExifExposure> exif_exposure(const std::string& jpeg) {
  constexpr double kLargestIso = 65535.0;  // the tag is a SHORT
  const ExifTags tags(std::as_bytes(std::span(jpeg)));
  const double shutter_s = tags.number(EXIF_TAG_EXPOSURE_TIME).value_or(0.0);
  const double iso = tags.number(EXIF_TAG_ISO_SPEED_RATINGS).value_or(0.0);
  if (shutter_s <= 0.0 || iso < 1.0 || iso > kLargestIso) return std::nullopt;
  return ExifExposure{shutter_s, static_cast<int>(std::lround(iso))};
}

const std::vector<std::string>& exposure_option_names() {
  static const std::vector<std::string> names = {
      "exposureProgram",     "shutterSpeed",         "shutterSpeedSupport",         "iso",
      "isoSupport",          "exposureCompensation", "exposureCompensationSupport", "whiteBalance",
      "whiteBalanceSupport", "_colorTemperature"};
  return names;
}

double nearest_supported(const Json& options, const std::string& name, double wanted) {
  return nearest(options, name, wanted,
                 [](double a, double b) { return std::abs(std::log(a / b)); });
}

double nearest_compensation(const Json& options, double wanted_ev) {
  return nearest(options, "exposureCompensation", wanted_ev,
                 [](double a, double b) { return std::abs(a - b); });
}

ExifExposure chosen_exposure(const ExposureSettings& wanted,
                             const std::optional<ExifExposure>& measured, const Json& options) {
  const bool complete = wanted.shutter_s > 0.0 && wanted.iso > 0;
  if (!complete && !measured) {
    throw DeviceFault(FaultKind::kExposure,
                      "the camera does not report the exposure that it measured; set "
                      "camera.exposure.shutter_s and camera.exposure.iso");
  }
  // Brightness is proportional to shutter time times sensitivity.
  const double brightness = complete ? 0.0 : measured->shutter_s * measured->iso;
  const double iso = nearest_supported(options, "iso",
                                       wanted.iso > 0         ? wanted.iso
                                       : wanted.shutter_s > 0 ? brightness / wanted.shutter_s
                                                              : measured->iso);
  const double shutter_s = nearest_supported(
      options, "shutterSpeed", wanted.shutter_s > 0.0 ? wanted.shutter_s : brightness / iso);
  return {shutter_s, static_cast<int>(std::lround(std::clamp(iso, 1.0, 1e7)))};
}

Json locking_options(const ExifExposure& exposure, int white_balance_k, const Json& options) {
  Json locking = {{"exposureProgram", kManual},
                  {"shutterSpeed", number(exposure.shutter_s)},
                  {"iso", exposure.iso}};
  locking.update(white_balance_options(white_balance_k, options));
  return locking;
}

Json bracketed(const Json& locking, double ev, const Json& options) {
  Json brighter = locking;
  const double shutter_s = locking.at("shutterSpeed").get<double>() * std::exp2(ev);
  brighter["shutterSpeed"] = number(nearest_supported(options, "shutterSpeed", shutter_s));
  return brighter;
}

std::string first_difference(const Json& set, const Json& held) {
  return difference(set, held, kHeldTolerance_ev);
}

std::string first_difference(const Json& set, const ExifExposure& taken) {
  return difference({{"shutterSpeed", set.at("shutterSpeed")}, {"iso", set.at("iso")}},
                    {{"shutterSpeed", taken.shutter_s}, {"iso", taken.iso}}, kExifTolerance_ev);
}

}  // namespace raywalk::capture
