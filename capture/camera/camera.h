// A 360-degree camera that takes a picture when told to.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

// What is locked for a session, so that all its pictures can be blended. Without values the camera
// measures once, when it is prepared, and keeps what it found.
struct ExposureSettings {
  bool lock = true;
  double shutter_s = 0.0;               // 0: as the camera measures
  int iso = 0;                          // 0: as the camera measures
  int white_balance_k = 0;              // 0: as the camera measures
  std::vector<double> bracket_ev{0.0};  // one exposure per station each, relative to the above
};

// What a camera says of itself; what it cannot tell is none.
struct CameraReport {
  std::string identity;                    // maker, model, serial number, firmware
  std::string state;                       // "idle", "busy", ...
  std::optional<double> clock_offset_s{};  // the camera's clock minus this machine's
  std::string clock_source{};              // how it tells the time: "option dateTimeZone, +-0.5 s"
  std::optional<std::int64_t> free_bytes{};
  std::optional<int> pictures_left{};
  std::optional<double> battery_share{};  // 0 to 1
};

// One picture as the camera gave it: a whole JPEG or PNG file, checked for format, size and end.
struct Picture {
  std::string bytes;
  std::string extension;    // "jpg" or "png"
  std::string camera_name;  // on the camera's card; empty where it has none
  PanoramaSize size{};
  std::string exposure;  // settings read back for this picture, as JSON; empty where unknown
};

struct Shot {
  std::vector<Picture> pictures;  // one per bracket exposure, in its order; none if they stay on
                                  // the camera's card
  WallTime triggered_at{};
  WallTime exposed_at{};     // as near as the camera lets it be known
  double exposing_ms = 0.0;  // from the trigger to the picture being ready
  double transfer_ms = 0.0;  // fetching it
};

// Calls throw DeviceFault; Interrupted where they wait.
class Camera {
 public:
  virtual ~Camera() = default;

  virtual std::string description() const = 0;
  // Moves and changes nothing.
  virtual CameraReport report() = 0;
  // Once before the first shot of a run: sets and locks exposure and white balance, reads them back
  // and returns what holds, as JSON; empty where the camera cannot. `earlier` is what an earlier
  // run of the same session returned (empty: none): it is set again rather than measured anew.
  virtual std::string prepare(const ExposureSettings& exposure, const std::string& earlier) = 0;
  // Takes all exposures of one station. Nothing exposed before `settled_at` is returned.
  virtual Shot shoot(SteadyTime settled_at) = 0;
  // Start and end a film, for capture while the slider moves slowly. Throw UsageError for a camera
  // that this program cannot have film.
  virtual void start_film();
  virtual void stop_film();
  // Whether pictures stay on the camera's card, to be imported later.
  virtual bool keeps_pictures() const { return false; }
};

}  // namespace raywalk::capture
