// Opens the devices of a configuration. `raywalk-capture check` contacts every one without moving
// anything.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/camera/camera.h"
#include "capture/config/capture_config.h"
#include "capture/slider/slider_config.h"
#include "capture/slider/soft_limits.h"

namespace raywalk::capture {

// Throws DeviceFault if the device does not answer or is not the configured one, and UsageError for
// an invalid configuration. The clock must outlive the device.
std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock);

// The soft limits of a configuration. Throws UsageError as SoftLimits does.
SoftLimits limits_of(const SliderConfig& config);

struct DeviceCheck {
  std::string device;  // "slider", "camera", "disk"
  bool usable = false;
  std::string text;  // identity and state, or the error and what to do
};

// Checks all devices even if one fails. `disk` is the directory where sessions will be written,
// `lines` as for select_lines (line_selection.h).
std::vector<DeviceCheck> check_devices(const CaptureConfig& config,
                                       const std::filesystem::path& disk,
                                       const std::vector<std::string>& lines);

// Checks before a run whether its pictures will fit. Throw Error if the camera reports room for
// fewer pictures, or if the disk of the directory has less free space than the pictures (as far as
// their size is known) and run.least_free_mb take.
void require_room_on_card(const CameraReport& report, std::size_t pictures);
void require_room_on_disk(const std::filesystem::path& directory, std::size_t pictures,
                          const CaptureConfig& config);

}  // namespace raywalk::capture
