// The rig's camera: its card, its exposure, its clock and its faults, without the network.
//
// It behaves as the Ricoh Theta's Web API v2.1 documents: refuses commands while it is exposing,
// hides what automatic exposure found from its options, and writes it into the picture's EXIF.
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
#include "capture/simulated/rig/camera_faults.h"
#include "capture/simulated/rig/simulated_card.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {

// The picture that is being exposed now.
struct ExposureNow {
  std::string camera_name;   // on the card: "R0010001.JPG"
  std::uint64_t number = 0;  // of the trigger, from 1 since the camera was made; a key for noise
  double gain = 1.0;         // of linear light, against the exposure that the scene asks for
  double shutter_s = 0.0;    // as used, automatic or not
  int iso = 0;               // as used
  int white_balance_k = 0;   // as used
};

// Gives the encoded JPEG file of the moment it is called at. It is called in a server's thread,
// never twice at once. If it throws, the picture is missing.
using PictureSource = std::function<std::string(const ExposureNow&)>;

struct SimulatedCameraSettings {
  std::string model = "simulated";
  std::string serial_number = "00000001";
  std::string firmware_version = "1.0";
  std::filesystem::path card_directory;            // holds the pictures; made where it is missing
  std::int64_t card_bytes = 32'000'000'000;        // capacity
  std::int64_t typical_picture_bytes = 4'000'000;  // what the pictures left are counted by
  PanoramaSize frame{};                            // told as its file format; 0 x 0: not told
  double exposure_ms = 200.0;                      // from the trigger to the file being on the card
  double clock_offset_s = 0.0;                     // the camera's clock minus the given one
  double battery_share = 1.0;                      // 0 to 1
  // What the scene asks for, gain 1. Automatic exposure misses it by up to +- automatic_wander_ev,
  // by another amount at each picture, so that a session without a lock shows.
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

// What can be chosen, as the Ricoh Theta does.
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

// How far a trigger has come.
struct PictureProgress {
  bool done = false;
  double completion = 0.0;  // 0 to 1
  std::string camera_name;  // once done; empty if no file came of it
};

// Safe to use from several threads. All durations are those of the given clock.
class SimulatedCamera {
 public:
  // Throws Error for a card directory that cannot be made.
  SimulatedCamera(SimulatedCameraSettings settings, const Clock& clock, PictureSource source);
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  const SimulatedCameraSettings& settings() const { return settings_; }
  CameraOptions options() const;
  // Throws CommandRefused while exposing, and for what camera_support() does not hold.
  void set_options(const CameraOptions& options);

  // Exposes: calls the source at once, and has the file on the card when exposure_ms have passed.
  // Returns the command's id. Throws CommandRefused while exposing and with a full card.
  std::string take_picture();
  // Of the last trigger. Throws CommandRefused for any other id.
  PictureProgress progress_of(const std::string& id) const;
  bool is_exposing() const;
  std::uint64_t pictures_taken() const;  // triggers carried out, also those that failed
  std::string last_file() const;         // empty before the first

  SimulatedCard& card() { return card_; }
  int pictures_left() const;
  CameraFaults& faults() { return faults_; }
  // As taking out the battery: no fault is left, nothing is being exposed, automatic exposure.
  void restart();
  WallTime wall_now() const;  // by the camera's own clock

 private:
  struct Trigger {
    std::uint64_t number = 0;
    SteadyTime started{};
    bool stuck = false;       // for ever, by the fault kBusy given for once
    bool held = false;        // for as long as the fault kBusy lasts
    std::string camera_name;  // empty if no file comes of it
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
