// The devices that a configuration names.
#pragma once

#include <memory>

#include "capture/base/clock.h"
#include "capture/camera/camera_config.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// Throw DeviceFault if the device does not answer or is not the configured one, and UsageError for
// an invalid configuration. The clock must outlive the device.
std::unique_ptr<Slider> open_slider(const SliderConfig& config, Clock* clock);
std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock);

// The soft limits of a configuration. Throws UsageError as SoftLimits does.
SoftLimits limits_of(const SliderConfig& config);

}  // namespace raywalk::capture
