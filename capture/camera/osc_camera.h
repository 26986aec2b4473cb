// A camera that speaks the Open Spherical Camera API over HTTP: Ricoh Theta, Insta360 and others.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "capture/camera/camera_config.h"
#include "capture/camera/exif_exposure.h"
#include "capture/camera/osc_client.h"

namespace raywalk::capture {

// Pictures are fetched whole and checked, and stay on the camera's card as well. The file format is
// set to the configured size where there is one; else the first picture's size holds for the rest.
//
// Faults: kNoContact, kWrongDevice (something else answers there), kBusy (not done in time, or
// taken by another program), kCardFull, kMissingPicture, kBadPicture, kExposure.
//
// A trigger whose answer is lost is not repeated here, for the camera may have taken the picture:
// once the camera is idle this is kMissingPicture, the station is shot again, and the first
// picture, if there is one, remains on the card.
class OscCamera final : public Camera {
 public:
  // The clock must outlive the camera. Throws UsageError for an address that is none.
  OscCamera(const CameraConfig& config, Clock& clock);
  ~OscCamera() override;

  std::string description() const override;
  // The state is "idle", "shooting" or "ready", and what the camera complains of: "idle,
  // NO_MEMORY".
  CameraReport report() override;
  // Without values the camera takes one picture in automatic mode, which stays on its card; its
  // Exif data tell the exposure. The answer holds the options that were set, by their names in the
  // API.
  std::string prepare(const ExposureSettings& exposure, const std::string& earlier) override;
  // exposed_at is the moment the first trigger was sent: the API does not tell it better.
  Shot shoot(SteadyTime settled_at) override;

 private:
  struct Options;
  struct Taken {
    std::string file;  // as the API names it
    WallTime triggered_at{};
    double exposing_ms = 0.0;
  };

  void choose_file_format();
  std::optional<ExifExposure> measured_exposure();
  nlohmann::json chosen_lock(const ExposureSettings& exposure);
  void set(const nlohmann::json& options);
  nlohmann::json exposure_options(double ev) const;
  void check_promise();
  void check_promise(const std::string& bytes);
  Picture expose(double ev, Shot* shot);
  Taken take_picture();
  std::optional<OscCommand> begin_picture(SteadyTime deadline);
  void wait_for_idle(SteadyTime deadline);
  std::string finished_file(OscCommand command, SteadyTime deadline);
  std::string exposure_record(double ev, const std::string& bytes) const;
  bool is_card_full();
  [[noreturn]] void throw_card_full() const;
  void sleep_poll();

  CameraConfig config_;
  Clock& clock_;
  OscClient client_;
  ExposureSettings exposure_;
  std::unique_ptr<Options> options_;
  std::optional<SteadyTime> set_at_;
  PanoramaSize frame_;  // 0 x 0 before the first picture where none is configured
};

}  // namespace raywalk::capture
