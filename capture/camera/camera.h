// Interface to a 360-degree camera that is triggered by the program.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

// The exposure that is locked for a session, so that all its pictures can be blended. Values of 0
// are measured once by the camera, when it is prepared.
struct ExposureSettings {
  bool lock = true;
  double shutter_s = 0.0;               // 0: measured
  int iso = 0;                          // 0: measured
  int white_balance_k = 0;              // 0: measured
  std::vector<double> bracket_ev{0.0};  // the exposures of a station, relative to the above
};

// The state that a camera reports; values that it does not report are none.
struct CameraReport {
  std::string identity;  // maker, model, serial number, firmware
  std::string state;     // "idle", "busy", ...
  std::optional<std::int64_t> free_bytes{};
  std::optional<int> pictures_left{};
  std::optional<double> battery_share{};  // 0 to 1
};

// One picture as sent by the camera: a complete JPEG or PNG file of checked format and size.
struct Picture {
  std::string bytes;
  std::string extension;    // "jpg" or "png"
  std::string camera_name;  // file name on the camera's card; empty if none
  PanoramaSize size{};
  std::string exposure;  // settings read back for this picture, as JSON; empty if unknown
};

struct Shot {
  std::vector<Picture> pictures;  // one per exposure of the bracket, in its order; empty if they
                                  // stay on the camera's card
  WallTime triggered_at{};
  WallTime exposed_at{};     // as precisely as the camera reports it
  double exposing_ms = 0.0;  // from the trigger to the picture being ready
  double transfer_ms = 0.0;  // transfer to this machine
};

// Calls throw DeviceFault, and Interrupted while they wait.
class Camera {
 public:
  virtual ~Camera() = default;

  virtual std::string description() const = 0;
  // Changes nothing.
  virtual CameraReport report() = 0;
  // Called once before the first shot of a run: sets and locks exposure and white balance, reads
  // them back and returns them as JSON; empty if the camera cannot. `earlier` is the return value
  // of an earlier run of the session (empty: none), whose values are set again instead of measured.
  virtual std::string prepare(const ExposureSettings& exposure, const std::string& earlier) = 0;
  // Takes all exposures of one station. Returns no picture exposed before `settled_at`.
  virtual Shot shoot(SteadyTime settled_at) = 0;
  // Start and end a video, for capture while the slider moves slowly. Throw UsageError for a camera
  // that cannot record video under the program's control.
  virtual void start_video() { refuse_video(); }
  virtual void stop_video() { refuse_video(); }
  // Whether pictures stay on the camera's card and are imported later.
  virtual bool keeps_pictures() const { return false; }

 private:
  [[noreturn]] void refuse_video() const {
    throw UsageError(description() + " cannot record video under the program's control");
  }
};

}  // namespace raywalk::capture
