// The rig's camera without the network: card, exposure, clock and faults.
//
// It behaves as documented in the Ricoh Theta Web API v2.1: it refuses commands while exposing, and
// reports values chosen by automatic exposure only in the picture's Exif data, not in its options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/clock.h"
#include "core/geometry/sphere.h"
#include "simulator/rig/camera_faults.h"
#include "simulator/rig/simulated_card.h"

namespace raywalk::capture {

// The exposure in progress.
struct ExposureNow {
  std::string camera_name;   // on the card: "R0010001.JPG"
  std::uint64_t number = 0;  // of the trigger, from 1 since the camera was made; a key for noise
  double gain = 1.0;         // of linear light, relative to the metered exposure
  double shutter_s = 0.0;    // as used, automatic or not
  int iso = 0;               // as used
  int white_balance_k = 0;   // as used
};

// Returns an encoded JPEG file of the scene at the time of the call. Called from a server thread,
// never concurrently. If it throws, the picture is missing.
using PictureSource = std::function<std::string(const ExposureNow&)>;

struct SimulatedCameraSettings {
  std::string model = "simulated";
  std::string serial_number = "00000001";
  std::string firmware_version = "1.0";
  std::filesystem::path card_directory;            // holds the pictures; created if missing
  std::int64_t card_bytes = 32'000'000'000;        // capacity
  std::int64_t typical_picture_bytes = 4'000'000;  // for the number of pictures left
  PanoramaSize frame{};                            // reported as file format; 0 x 0: not reported
  double exposure_ms = 200.0;                      // from the trigger until the file is on the card
  double clock_offset_s = 0.0;                     // the camera's clock minus `clock`
  double battery_share = 1.0;                      // 0 to 1
  // The metered exposure, which gives gain 1. Automatic exposure deviates from it by up to
  // +- automatic_wander_ev, differently for each picture, so that a missing exposure lock shows.
  double metered_shutter_s = 1.0 / 60.0;
  int metered_iso = 100;
  int metered_white_balance_k = 5000;
  double automatic_wander_ev = 0.3;
};

// Shooting options as the Open Spherical Camera API names them.
struct CameraOptions {
  int exposure_program = 2;            // 1 manual, 2 automatic
  double shutter_s = 0.0;              // shutterSpeed; 0 while automatic
  int iso = 0;                         // 0 while automatic
  double compensation_ev = 0.0;        // exposureCompensation; 0 while manual
  std::string white_balance = "auto";  // or "_colorTemperature", "daylight", ...
  int color_temperature_k = 5000;      // 2500 to 10000 in steps of 100
};

// Supported values, as those of the Ricoh Theta.
struct CameraSupport {
  std::vector<double> shutter_s;
  std::vector<int> iso;
  std::vector<double> compensation_ev;
  std::vector<std::string> white_balance;
};
const CameraSupport& camera_support();

// A command that the camera refuses: what() is the API's message, code its error code
// ("disabledCommand", "invalidParameterValue", "serviceUnavailable", ...).
class CommandRefused : public std::runtime_error {
 public:
  CommandRefused(std::string code, const std::string& message)
      : std::runtime_error(message), code_(std::move(code)) {}
  const std::string& code() const { return code_; }

 private:
  std::string code_;
};

// Progress of a trigger.
struct PictureProgress {
  bool done = false;
  double completion = 0.0;  // 0 to 1
  std::string camera_name;  // once done; empty if there is no file
};

// Thread-safe. All durations are measured on the given clock.
class SimulatedCamera {
 public:
  // Throws Error if the card directory cannot be created.
  SimulatedCamera(SimulatedCameraSettings settings, const Clock& clock, PictureSource source);
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  const SimulatedCameraSettings& settings() const { return settings_; }
  CameraOptions options() const;
  // Throws CommandRefused while exposing, and for values not in camera_support().
  void set_options(const CameraOptions& options);

  // Starts an exposure: calls the source immediately; the file is on the card after exposure_ms.
  // Returns the command's id. Throws CommandRefused while exposing and if the card is full.
  std::string take_picture();
  // Progress of the last trigger. Throws CommandRefused for any other id.
  PictureProgress progress_of(const std::string& id) const;
  bool is_exposing() const;
  std::uint64_t pictures_taken() const;  // accepted triggers, including failed ones
  std::string last_file() const;         // empty before the first

  SimulatedCard& card() { return card_; }
  int pictures_left() const;
  CameraFaults& faults() { return faults_; }
  // Power cycle: removes all faults, aborts the exposure and resets the options.
  void restart();
  WallTime wall_now() const;  // by the camera's own clock

 private:
  struct Trigger {
    std::uint64_t number = 0;
    SteadyTime started{};
    bool stuck = false;       // until a restart, by kBusy without a duration
    bool held = false;        // while kBusy lasts
    std::string camera_name;  // empty if there will be no file
  };

  bool is_exposing_locked() const;
  Trigger begin_locked();
  ExposureNow exposure_locked(const Trigger& trigger) const;
  bool expose(const ExposureNow& exposure);
  std::string damaged(const std::string& jpeg, std::uint64_t number);

  const SimulatedCameraSettings settings_;
  const Clock& clock_;
  const PictureSource source_;
  CameraFaults faults_;
  SimulatedCard card_;
  mutable std::mutex mutex_;
  CameraOptions options_;
  std::uint64_t triggers_ = 0;
  Trigger trigger_;  // the last one
  bool rendering_ = false;
  std::string file_before_;  // the last one on the card before the trigger
};

}  // namespace raywalk::capture
