#include "capture/config/rig_addresses.h"

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::capture {
namespace {

constexpr std::size_t kMaxAddressBytes = 1 << 16;

CheckedJson read_addresses(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) {
    throw UsageError(file.parent_path().string() +
                     ": no simulated rig runs there; start one with raywalk-simulate rig");
  }
  return CheckedJson::parse(read_file(file, kMaxAddressBytes), file.string(),
                            "start the simulated rig again");
}

}  // namespace

void use_rig_addresses(CaptureConfig* config, const std::filesystem::path& directory) {
  if (config->camera.kind != CameraKind::kOsc) {
    refuse_setting(*config, "camera.kind", "the simulated rig's camera is 'osc'");
  }
  try {
    const CheckedJson rig = read_addresses(directory / "rig.json");
    config->slider.device = rig.at("slider").text();
    config->slider.rs485 = false;
    config->slider.host = "127.0.0.1";
    config->slider.port = rig.at("modbus_port").integer(1, 65535);
    config->camera.osc.url = rig.at("camera_url").text();
    config->run.place_url = config->camera.osc.url + "/rig/place";
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

}  // namespace raywalk::capture
