#include "capture/run/open_devices.h"

#include "capture/camera/gpio_camera.h"
#include "capture/camera/osc_camera.h"
#include "capture/camera/v4l2_camera.h"
#include "capture/camera/v4l2_device.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"

namespace raywalk::capture {

std::unique_ptr<Slider> open_slider(const SliderConfig& config, Clock* clock) {
  return make_modbus_slider(config, clock);
}

std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock) {
  if (config.kind == "osc") return std::make_unique<OscCamera>(config, *clock);
  if (config.kind == "v4l2") {
    return std::make_unique<V4l2Camera>(config, open_video_device(config.v4l2.device), clock);
  }
  if (config.kind == "gpio") {
    return std::make_unique<GpioCamera>(config.trigger, open_gpio_chip(config.trigger.chip), clock);
  }
  throw UsageError("unknown kind of camera " + excerpt(config.kind));
}

SoftLimits limits_of(const SliderConfig& config) {
  return SoftLimits(config.low_limit_mm, config.high_limit_mm);
}

}  // namespace raywalk::capture
