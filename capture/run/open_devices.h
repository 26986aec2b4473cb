// The devices that a configuration names.
#pragma once

#include <memory>

#include "capture/base/clock.h"
#include "capture/camera/camera_config.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// Throw DeviceFault where the device does not answer or is another one, and UsageError for a
// configuration that names none. The clock has to outlive what they return.
std::unique_ptr<Slider> open_slider(const SliderConfig& config, Clock* clock);
std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock);

// The soft limits of a configuration. Throws UsageError as SoftLimits does.
SoftLimits limits_of(const SliderConfig& config);

}  // namespace raywalk::capture
