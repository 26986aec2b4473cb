#include "capture/run/open_devices.h"

#include <stdexcept>

#include "capture/camera/gpio_camera.h"
#include "capture/camera/osc_camera.h"
#include "capture/camera/v4l2_camera.h"
#include "capture/camera/video_device.h"
#include "capture/slider/modbus_slider.h"

namespace raywalk::capture {

std::unique_ptr<Slider> open_slider(const SliderConfig& config, Clock* clock) {
  return make_modbus_slider(config, clock);
}

std::unique_ptr<Camera> open_camera(const CameraConfig& config, Clock* clock) {
  switch (config.kind) {
    case CameraKind::kOsc:
      return std::make_unique<OscCamera>(config, *clock);
    case CameraKind::kV4l2:
      return std::make_unique<V4l2Camera>(config, open_video_device(config.v4l2.device), clock);
    case CameraKind::kGpio:
      return std::make_unique<GpioCamera>(config.trigger, open_gpio_chip(config.trigger.chip),
                                          clock);
  }
  throw std::logic_error("unknown kind of camera");
}

SoftLimits limits_of(const SliderConfig& config) {
  return SoftLimits(config.low_limit_mm, config.high_limit_mm);
}

}  // namespace raywalk::capture
