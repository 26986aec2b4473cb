#include "capture/config/rig_addresses.h"

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::capture {
namespace {

constexpr std::size_t kMaxAddressBytes = 1 << 16;

nlohmann::json read_addresses(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) {
    throw UsageError(file.parent_path().string() +
                     ": no simulated rig runs there; start one with raywalk-capture simulate");
  }
  try {
    return nlohmann::json::parse(read_file(file, kMaxAddressBytes));
  } catch (const nlohmann::json::exception&) {
    throw UsageError(file.string() + ": damaged; start the simulated rig again");
  }
}

}  // namespace

void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory) {
  if (config->camera.kind != CameraKind::kOsc) {
    refuse_setting(*config, "camera.kind", "the simulated rig's camera is 'osc'");
  }
  const std::filesystem::path file = directory / "rig.json";
  const nlohmann::json rig = read_addresses(file);
  try {
    config->slider.device = rig.at("slider").get<std::string>();
    config->slider.rs485 = false;
    config->slider.host = "127.0.0.1";
    config->slider.port = rig.at("modbus_port").get<int>();
    config->camera.osc.url = rig.at("camera_url").get<std::string>();
    config->run.place_url = config->camera.osc.url + "/rig/place";
  } catch (const nlohmann::json::exception&) {
    throw UsageError(file.string() + ": not written by a simulated rig; start the rig again");
  }
}

}  // namespace raywalk::capture
