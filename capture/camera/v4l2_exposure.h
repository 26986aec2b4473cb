// Exposure, gain and white balance of a V4L2 camera, locked for a session.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>

#include "capture/base/device_fault.h"
#include "capture/camera/camera.h"
#include "capture/camera/video_device.h"

namespace raywalk::capture {

// Whether exposures are anything but one at the locked exposure itself.
bool is_bracketed(std::span<const double> bracket_ev);

// Locks what the camera lets be locked: automatics off, values fixed. Where the configuration gives
// no value the camera's automatic measures one. A camera may report an old exposure while its
// automatic is on; whatever it reports is then set, so that every run of the session has the same.
// The device must outlive this. Throws DeviceFault kExposure where the camera does not do as told.
class V4l2Exposure {
 public:
  explicit V4l2Exposure(VideoDevice* device) : device_(device) {}

  // Locks, reads back, and returns what holds as JSON, {"exposure_100us": 156, "gain": 4, ...};
  // empty where nothing is to be locked or the camera has no such controls. `earlier`, not empty,
  // is such a text, whose values are set again. `measure` is called with the automatics on, and
  // returns once they have had time to settle. Throws UsageError: ISO, which V4L2 cameras do not
  // know, or a bracket without the lock.
  std::string lock(const ExposureSettings& settings, const std::string& earlier,
                   const std::function<void()>& measure);

  // Changes the locked exposure time by a factor 2^ev until the next call.
  void bracket(double ev);

  // The exposure time in force; zero where it is not locked.
  Duration locked_time() const;

  // Reads everything back and returns it as lock does.
  std::string confirm();

 private:
  using Values = std::map<VideoControl, int>;

  Values wanted_values(const ExposureSettings& settings, const std::string& earlier) const;
  bool switch_on_automatics(const Values& wanted);
  void fix_values(const Values& wanted);
  void switch_off(VideoControl mode, int value_off);
  void hold(VideoControl control, int value);
  void expect(VideoControl control, int wanted, int tolerance);
  int bracketed(double ev);
  DeviceFault fault(const std::string& what) const;

  VideoDevice* device_;
  Values locked_;
  Values off_;             // modes in which the automatics are off
  int base_exposure_ = 0;  // without a bracket
};

}  // namespace raywalk::capture
