// `raywalk-capture check`: contacts every device of a configuration without moving anything.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"

namespace raywalk::capture {

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

// One line per device.
std::string text_of(const std::vector<DeviceCheck>& checks);
// Whether a run can start.
bool all_usable(const std::vector<DeviceCheck>& checks);

}  // namespace raywalk::capture
