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

// Whether there is more than one exposure, or one other than 0 EV.
bool is_bracketed(std::span<const double> bracket_ev);

// Switches off the camera's automatics and fixes their values, for all controls that the camera
// has. Values that the configuration does not give are measured by the automatics. A camera may
// report an outdated exposure while its automatic is on; the reported value is set, so that all
// runs of the session use the same. The device must outlive this object. Throws DeviceFault
// kExposure if the camera does not accept or keep a setting.
class V4l2Exposure {
 public:
  explicit V4l2Exposure(VideoDevice* device) : device_(device) {}

  // Locks, reads back and returns the values as JSON, {"exposure_100us": 156, "gain": 4, ...};
  // empty if nothing is to be locked or the camera has no such controls. `earlier`, if not empty,
  // is such a text, whose values are set again. `measure` is called with the automatics on and
  // returns once they have settled. Throws UsageError for an ISO value, which V4L2 does not have,
  // or a bracket without the lock.
  std::string lock(const ExposureSettings& settings, const std::string& earlier,
                   const std::function<void()>& measure);

  // Sets the exposure time to 2^ev times the locked one, until the next call.
  void bracket(double ev);

  // The current exposure time; zero if it is not locked.
  Duration locked_time() const;

  // Reads all locked values back, checks them and returns them as lock() does.
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
  Values off_;             // the modes' values with the automatics off
  int base_exposure_ = 0;  // without a bracket
};

}  // namespace raywalk::capture
