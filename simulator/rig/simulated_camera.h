// The rig's camera without the network: card, exposure, clock, and its answers to the Open
// Spherical Camera API, level 2.
//
// It behaves as documented in the Ricoh Theta Web API v2.1 (github.com/ricohapi/theta-api-specs):
// it refuses commands while exposing, and reports values chosen by automatic exposure only in the
// picture's Exif data, not in its options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/base/clock.h"
#include "core/geometry/sphere.h"
#include "simulator/rig/faults.h"

namespace raywalk::simulator {

// The exposure in progress.
struct ExposureNow {
  std::string camera_name;   // on the card: "R0010001.JPG"
  std::uint64_t number = 0;  // of the trigger, from 1 since the camera was made; a key for noise
  double gain = 1.0;         // of linear light, relative to the metered exposure
  double shutter_s = 0.0;    // as used, automatic or not
  int iso = 0;               // as used
  bool automatic = false;
};

// Returns an encoded JPEG file of the scene at the time of the call. Called from a server thread,
// never concurrently. If it throws, the picture is missing.
using PictureSource = std::function<std::string(const ExposureNow&)>;

struct SimulatedCameraSettings {
  std::filesystem::path card_directory;            // holds the pictures; created if missing
  std::int64_t card_bytes = 32'000'000'000;        // capacity
  std::int64_t typical_picture_bytes = 4'000'000;  // for the number of pictures left
  PanoramaSize frame{};                            // reported as file format
  double exposure_ms = 200.0;                      // from the trigger until the file is on the card
  double clock_offset_s = 0.0;                     // the camera's clock minus `clock`
  double battery_share = 1.0;                      // 0 to 1
  // Automatic exposure deviates from the metered one by up to this, differently for each picture,
  // so that a missing exposure lock shows.
  double automatic_wander_ev = 0.3;
};

struct OscReply {
  int http_status = 200;
  nlohmann::json json{};
};

// Thread-safe. All durations are measured on the given clock. `base_url` is the address of the
// camera's files: "http://127.0.0.1:8080".
class SimulatedCamera {
 public:
  // Files already on the card are kept, and numbering continues after them. Clock and faults must
  // outlive the camera. Throws Error if the card's directory cannot be created.
  SimulatedCamera(SimulatedCameraSettings settings, const Clock* clock, Faults* faults,
                  PictureSource source);
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  static OscReply info();                     // GET /osc/info
  OscReply state() const;                     // POST /osc/state
  OscReply execute(const std::string& body);  // POST /osc/commands/execute
  // POST /osc/commands/status
  OscReply status(const std::string& body, const std::string& base_url) const;
  // The bytes of a file on the card. Throws Error if there is none of that name.
  std::string file(const std::string& name) const;

  // Power cycle: aborts the exposure and resets the options.
  void restart();
  nlohmann::json options() const;        // those that can be set, by their names in the API
  std::uint64_t pictures_taken() const;  // accepted triggers, including failed ones
  int pictures_left() const;
  bool is_exposing() const;

 private:
  using Json = nlohmann::json;
  struct Trigger {
    std::uint64_t number = 0;
    SteadyTime started{};
    bool busy = false;        // as long as the fault of that name lasts
    std::string camera_name;  // empty if there will be no file
  };

  Json run(const std::string& command, const Json& parameters);
  Json option(const std::string& name) const;
  void set_options(const Json& wanted);
  Json take_picture();
  ExposureNow exposure_now() const;
  bool expose(const ExposureNow& exposure);
  std::int64_t free_bytes() const;
  void require_idle() const;

  const SimulatedCameraSettings settings_;
  const Clock* clock_;
  Faults* faults_;
  const PictureSource source_;
  mutable std::recursive_mutex mutex_;  // the API's functions call each other
  std::int64_t used_bytes_ = 0;         // of the card
  int last_number_;
  Json options_;
  std::uint64_t triggers_ = 0;
  Trigger trigger_;  // the last one
  bool rendering_ = false;
};

}  // namespace raywalk::simulator
