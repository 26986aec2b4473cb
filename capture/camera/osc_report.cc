#include "capture/camera/osc_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/camera/osc_client.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

std::string identity_in(const Json& info) {
  // Ricoh repeats the manufacturer in the model's name.
  const std::string manufacturer = text_at(info, "manufacturer");
  const bool repeated = text_at(info, "model").starts_with(manufacturer);
  std::string identity = repeated ? std::string{} : manufacturer;
  const auto append = [&](const std::string& separator, const std::string& text) {
    if (!text.empty()) identity += (identity.empty() ? "" : separator) + text;
  };
  append(" ", text_at(info, "model"));
  append(", serial ", text_at(info, "serialNumber"));
  append(", firmware ", text_at(info, "firmwareVersion"));
  return one_line(identity);
}

// "_captureStatus" and "_cameraError" are Ricoh's, "_cardState" is Insta360's.
std::string state_in(const Json& state) {
  std::string text = text_at(state, "_captureStatus");
  if (text.empty()) text = "ready";
  const auto errors = state.find("_cameraError");
  if (errors != state.end() && errors->is_array()) {
    for (const Json& error : *errors) {
      if (error.is_string()) text += ", " + error.get<std::string>();
    }
  }
  const std::string card = text_at(state, "_cardState");
  if (!card.empty() && card != "pass") text += ", card: " + card;
  return one_line(text);
}

}  // namespace

const std::vector<std::string>& report_option_names() {
  static const std::vector<std::string> names = {"remainingPictures", "remainingSpace",
                                                 "totalSpace"};
  return names;
}

CameraReport osc_report(const Json& info, const Json& state, const Json& options) {
  CameraReport report;
  report.identity = identity_in(info);
  report.state = state_in(state);
  const auto battery = number_at(state, "batteryLevel");
  if (battery && *battery >= 0.0 && *battery <= 1.0) report.battery_share = battery;
  if (const auto pictures = count_at(options, "remainingPictures")) {
    report.pictures_left = static_cast<int>(std::min<std::int64_t>(*pictures, 1'000'000'000));
  }
  // Insta360's documentation shows 0 of 0 bytes for a camera that does not know.
  if (number_at(options, "totalSpace") != 0.0) {
    report.free_bytes = count_at(options, "remainingSpace");
  }
  return report;
}

bool reports_full_card(const Json& state, const Json& options) {
  const auto errors = state.find("_cameraError");
  const bool no_memory = errors != state.end() && errors->is_array() &&
                         std::find(errors->begin(), errors->end(), "NO_MEMORY") != errors->end();
  return no_memory || text_at(state, "_cardState") == "noSpace" ||
         count_at(options, "remainingPictures") == 0;
}

}  // namespace raywalk::capture
