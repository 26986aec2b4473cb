// A camera with the Open Spherical Camera API over HTTP: Ricoh Theta, Insta360 and others.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/base/device_fault.h"
#include "capture/camera/camera_config.h"
#include "capture/camera/osc_client.h"
#include "capture/camera/osc_exposure.h"

namespace raywalk::capture {

// Pictures are downloaded and checked; they also stay on the camera's card. The file format is set
// to the configured size, if any; otherwise all pictures must have the size of the first one.
//
// Faults: kNoContact, kWrongDevice (another device answers), kBusy (not done in time, or in use by
// another program), kCardFull, kMissingPicture, kBadPicture, kExposure.
//
// A trigger whose reply is lost is not repeated, because the camera may have taken the picture:
// once the camera is idle, kMissingPicture is thrown and the station is shot again. The first
// picture, if any, remains on the card.
class OscCamera final : public Camera {
 public:
  // The clock must outlive the camera. Throws UsageError for an invalid address.
  OscCamera(const CameraConfig& config, Clock& clock);
  ~OscCamera() override;

  std::string description() const override;
  // The state is "idle", "shooting" or "ready", with the camera's errors: "idle, NO_MEMORY".
  CameraReport report() override;
  // For values that are not given, the camera takes one picture in automatic mode, which stays on
  // its card, and the exposure is read from its Exif data. Returns the options that were set, by
  // their names in the API.
  std::string prepare(const ExposureSettings& exposure, const std::string& earlier) override;
  // exposed_at is the time the first trigger was sent: the API reports no better one.
  Shot shoot(SteadyTime settled_at) override;

 private:
  struct Options;
  struct Taken {
    std::string file;  // name in the API
    WallTime triggered_at{};
    double exposing_ms = 0.0;
  };

  DeviceFault fault_of(const OscRefusal& refusal) const;
  DeviceFault busy_fault(const std::string& detail) const;
  void choose_file_format();
  std::optional<ExifExposure> measured_exposure();
  nlohmann::json chosen_lock(const ExposureSettings& exposure);
  void set(const nlohmann::json& options);
  nlohmann::json exposure_options(double ev) const;
  void check_exposure(const std::optional<ExifExposure>& taken = {});
  Picture expose(double ev, Shot* shot);
  Taken take_picture();
  std::optional<OscCommand> begin_picture(SteadyTime until);
  bool is_idle();
  std::string finished_file(OscCommand command, SteadyTime until);
  void throw_if_card_full();
  SteadyTime deadline() const;
  void sleep_poll(SteadyTime until, const std::string& detail);
  void sleep_poll();

  CameraConfig config_;
  Clock& clock_;
  OscClient client_;
  ExposureSettings exposure_;
  std::unique_ptr<Options> options_;
  std::optional<SteadyTime> set_at_;
  PanoramaSize frame_;  // 0 x 0 before the first picture if none is configured
};

// From the replies to /osc/info and /osc/state and the options, each an object; missing or invalid
// members are left out.
CameraReport osc_report(const nlohmann::json& info, const nlohmann::json& state,
                        const nlohmann::json& options);

// Whether the camera reports no room for another picture.
bool reports_full_card(const nlohmann::json& state, const nlohmann::json& options);

}  // namespace raywalk::capture
