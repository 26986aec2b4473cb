#include "simulator/rig/simulated_camera.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

using Json = nlohmann::json;

constexpr int kManual = 1;  // exposureProgram
constexpr int kAutomatic = 2;
constexpr double kKeptShare = 0.6;  // of a truncated picture's bytes
// The metered exposure, which gives gain 1.
constexpr double kMeteredShutter_s = 1.0 / 60.0;
constexpr int kMeteredIso = 100;
constexpr const char* kModel = "simulated";
// DCF (JEITA CP-3461): eight characters and an extension. Ricoh writes R001 and four digits, then R
// and seven digits once those are exhausted.
constexpr int kFirstNumber = 10001;

// A command that the camera refuses, with the API's error code.
struct CommandRefused {
  std::string code;
  std::string message;
};

// What `make` answers to a request, or the API's error.
OscReply answered(const std::string& body, const std::function<Json(const Json&)>& make) {
  std::string code = "invalidParameterValue";
  std::string message;
  try {
    return {200, make(Json::parse(body))};
  } catch (const CommandRefused& refused) {
    code = refused.code;
    message = refused.message;
  } catch (const Json::out_of_range& missing) {
    code = "missingParameter";
    message = missing.what();
  } catch (const Json::exception& wrong) {
    message = wrong.what();
  }
  return {code == "disabledCommand" ? 403 : 400,
          {{"state", "error"}, {"error", {{"code", code}, {"message", message}}}}};
}

Json color_temperatures() {
  Json kelvins = Json::array();
  for (int kelvin = 2500; kelvin <= 10000; kelvin += 100) kelvins.push_back(kelvin);
  return kelvins;
}

struct OptionValues {
  Json initial;
  Json supported;
};

// The options that can be set: those of the Ricoh Theta V and Z1 (Web API v2.1); exposures longer
// than a second are left out. An automatic exposure program chooses what is 0.
const std::map<std::string, OptionValues>& option_values() {
  static const std::map<std::string, OptionValues> values{
      {"captureMode", {"image", Json::array({"image"})}},
      {"exposureProgram", {kAutomatic, Json::array({kManual, kAutomatic})}},
      {"shutterSpeed",
       {0, {0.00004, 0.00005,    0.0000625, 0.00008, 0.0001,     0.000125,   0.00015625,
            0.0002,  0.00025,    0.0003125, 0.0004,  0.0005,     0.000625,   0.0008,
            0.001,   0.00125,    0.0015625, 0.002,   0.0025,     0.003125,   0.004,
            0.005,   0.00625,    0.008,     0.01,    0.0125,     0.01666666, 0.02,
            0.025,   0.03333333, 0.04,      0.05,    0.06666666, 0.07692307, 0.1,
            0.125,   0.16666666, 0.2,       0.25,    0.33333333, 0.4,        0.5,
            0.625,   0.76923076, 1.0}}},
      {"iso",
       {0,
        {80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250, 1600, 2000, 2500,
         3200}}},
      {"exposureCompensation",
       {0.0, {-2.0, -1.7, -1.3, -1.0, -0.7, -0.3, 0.0, 0.3, 0.7, 1.0, 1.3, 1.7, 2.0}}},
      {"whiteBalance",
       {"auto",
        {"auto", "daylight", "shade", "cloudy-daylight", "incandescent", "fluorescent",
         "_colorTemperature"}}},
      {"_colorTemperature", {5000, color_temperatures()}}};
  return values;
}

Json initial_options() {
  Json options;
  for (const auto& [name, values] : option_values()) options[name] = values.initial;
  return options;
}

// Numbers that clients send back in decimal are rounded.
bool is_same(const Json& a, const Json& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  return std::abs(a.get<double>() - b.get<double>()) <= 1e-6 * std::abs(b.get<double>());
}

double nearest_shutter(double wanted_s) {
  const auto values = option_values().at("shutterSpeed").supported.get<std::vector<double>>();
  return *std::min_element(values.begin(), values.end(), [wanted_s](double a, double b) {
    return std::abs(std::log(a / wanted_s)) < std::abs(std::log(b / wanted_s));
  });
}

// A JPEG file with what cameras tell of their exposure (Exif 2.32, CIPA DC-008); times are UTC.
std::string with_exif(const std::string& jpeg, const ExposureNow& exposure, WallTime taken_at) {
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(taken_at);
  const auto ms = std::chrono::floor<std::chrono::milliseconds>(taken_at - whole_s).count();
  const std::string date = fmt::format("{:%Y:%m:%d %H:%M:%S}",
                                       fmt::gmtime(std::chrono::system_clock::to_time_t(whole_s)));
  // 1/60 s rather than 16667/1000000 s.
  const auto rounded = [](double value) { return static_cast<std::uint32_t>(std::lround(value)); };
  const TiffEntry time =
      exposure.shutter_s < 0.3
          ? rational_entry(EXIF_TAG_EXPOSURE_TIME, 1, rounded(1.0 / exposure.shutter_s))
          : rational_entry(EXIF_TAG_EXPOSURE_TIME, rounded(exposure.shutter_s * 10.0), 10);
  const std::string block =
      exif_block({ascii_entry(EXIF_TAG_MAKE, "Raywalk"), ascii_entry(EXIF_TAG_MODEL, kModel)},
                 {ascii_entry(EXIF_TAG_DATE_TIME_ORIGINAL, date),
                  ascii_entry(EXIF_TAG_SUB_SEC_TIME_ORIGINAL, fmt::format("{:03}", ms)),
                  ascii_entry(EXIF_TAG_OFFSET_TIME_ORIGINAL, "+00:00"), time,
                  short_entry(EXIF_TAG_ISO_SPEED_RATINGS, static_cast<std::uint16_t>(exposure.iso)),
                  short_entry(EXIF_TAG_EXPOSURE_PROGRAM, exposure.automatic ? 2 : 1),
                  short_entry(EXIF_TAG_WHITE_BALANCE, exposure.automatic ? 0 : 1)});
  return with_app1(jpeg, kExifIdentifier, block);
}

// The number in "R0010001.JPG"; 0 for another file.
int number_in(const std::string& name) {
  if (name.size() != 12 || name.front() != 'R' || name.substr(8) != ".JPG") return 0;
  return parse_whole_number(name.substr(1, 7)).value_or(0);
}

}  // namespace

SimulatedCamera::SimulatedCamera(SimulatedCameraSettings settings, const Clock* clock,
                                 Faults* faults, PictureSource source)
    : settings_(std::move(settings)),
      clock_(clock),
      faults_(faults),
      source_(std::move(source)),
      last_number_(kFirstNumber - 1),
      options_(initial_options()) {
  make_directories(settings_.card_directory);
  for (const auto& entry : std::filesystem::directory_iterator(settings_.card_directory)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || number_in(name) == 0) continue;
    used_bytes_ += static_cast<std::int64_t>(entry.file_size());
    last_number_ = std::max(last_number_, number_in(name));
  }
}

OscReply SimulatedCamera::info() {
  return {200,
          {{"manufacturer", "Raywalk"},
           {"model", kModel},
           {"serialNumber", "00000001"},
           {"firmwareVersion", "1.0"},
           {"api", {"/osc/info", "/osc/state", "/osc/commands/execute", "/osc/commands/status"}},
           {"apiLevel", Json::array({2})}}};
}

OscReply SimulatedCamera::state() const {
  const std::lock_guard lock(mutex_);
  const bool full = pictures_left() < 1;
  const Json state = {{"batteryLevel", settings_.battery_share},
                      {"_captureStatus", is_exposing() ? "shooting" : "idle"},
                      {"_apiVersion", 2},
                      {"_cameraError", full ? Json::array({"NO_MEMORY"}) : Json::array()}};
  return {200, {{"fingerprint", fmt::format("FIG_{}", triggers_)}, {"state", state}}};
}

OscReply SimulatedCamera::execute(const std::string& body) {
  return answered(body, [this](const Json& request) {
    const auto name = request.at("name").get<std::string>();
    Json reply = {{"name", name}, {"state", "done"}};
    reply.update(run(name, request.value("parameters", Json::object())));
    return reply;
  });
}

// What the reply holds in addition to the command's name and "done".
Json SimulatedCamera::run(const std::string& command, const Json& parameters) {
  if (command == "camera.getOptions") {
    Json options = Json::object();
    for (const Json& name : parameters.at("optionNames")) {
      options[name.get<std::string>()] = option(name.get<std::string>());
    }
    return {{"results", {{"options", options}}}};
  }
  if (command == "camera.setOptions") {
    set_options(parameters.at("options").get<Json::object_t>());
    return Json::object();
  }
  if (command == "camera.takePicture") return take_picture();
  throw CommandRefused{"unknownCommand", "Command executed is unknown."};
}

// The progress of the last trigger.
OscReply SimulatedCamera::status(const std::string& body, const std::string& base_url) const {
  return answered(body, [&](const Json& request) -> Json {
    const std::lock_guard lock(mutex_);
    if (trigger_.number == 0 || request.at("id") != std::to_string(trigger_.number)) {
      throw CommandRefused{"invalidParameterValue", "There is no command with this id."};
    }
    if (is_exposing()) {
      const double passed_ms = ms_from_duration(clock_->now() - trigger_.started);
      const double share = std::min(passed_ms / std::max(settings_.exposure_ms, 1.0), 0.99);
      return {{"name", "camera.takePicture"},
              {"id", request.at("id")},
              {"state", "inProgress"},
              {"progress", {{"completion", share}}}};
    }
    // A camera that failed to take the picture reports done without a file.
    Json results = Json::object();
    if (!trigger_.camera_name.empty()) {
      results["fileUrl"] = base_url + "/files/" + trigger_.camera_name;
    }
    return {{"name", "camera.takePicture"}, {"state", "done"}, {"results", results}};
  });
}

Json SimulatedCamera::options() const {
  const std::lock_guard lock(mutex_);
  return options_;
}

Json SimulatedCamera::option(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  Json format = {
      {"type", "jpeg"}, {"width", settings_.frame.width}, {"height", settings_.frame.height}};
  if (name == "fileFormat") return format;
  if (name == "fileFormatSupport") return Json::array({format});
  if (name == "remainingPictures") return pictures_left();
  if (name == "remainingSpace") return free_bytes();
  if (name == "totalSpace") return settings_.card_bytes;
  if (const auto value = options_.find(name); value != options_.end()) return *value;
  const std::string supported_name = name.substr(0, name.rfind("Support"));
  const auto supported = option_values().find(supported_name);
  if (supported_name == name || supported == option_values().end()) {
    throw CommandRefused{"invalidParameterName", "Option " + name + " is not supported."};
  }
  // With an automatic exposure program the Theta only supports 0 (automatic).
  const bool is_chosen = name == "shutterSpeedSupport" || name == "isoSupport";
  if (is_chosen && options_["exposureProgram"] != kManual) return Json::array({0});
  return supported->second.supported;
}

void SimulatedCamera::set_options(const Json& wanted) {
  const std::lock_guard lock(mutex_);
  require_idle();
  Json options = options_;
  for (const auto& [name, value] : wanted.items()) {
    const auto supported = option_values().find(name);
    if (supported == option_values().end()) {
      throw CommandRefused{"invalidParameterName", "Option " + name + " cannot be set."};
    }
    const bool is_left_to_camera = (name == "shutterSpeed" || name == "iso") && value == 0;
    const auto is_wanted = [&value = value](const Json& other) { return is_same(other, value); };
    if (!is_left_to_camera && std::ranges::none_of(supported->second.supported, is_wanted)) {
      throw CommandRefused{"invalidParameterValue", "The value of " + name + " is not supported."};
    }
    options[name] = value;
  }
  if (options["exposureProgram"] == kManual) {
    // On leaving automatic exposure, unset values start from the metered ones.
    if (options["shutterSpeed"] == 0) options["shutterSpeed"] = nearest_shutter(kMeteredShutter_s);
    if (options["iso"] == 0) options["iso"] = kMeteredIso;
    options["exposureCompensation"] = 0.0;
  } else {
    options["shutterSpeed"] = options["iso"] = 0;
  }
  options_ = options;
}

void SimulatedCamera::require_idle() const {
  if (is_exposing()) throw CommandRefused{"disabledCommand", "The camera is shooting."};
}

bool SimulatedCamera::is_exposing() const {
  const std::lock_guard lock(mutex_);
  if (trigger_.number == 0) return false;
  return rendering_ || (trigger_.busy && faults_->lasting(RigFault::kBusy)) ||
         clock_->now() < trigger_.started + duration_from_ms(settings_.exposure_ms);
}

ExposureNow SimulatedCamera::exposure_now() const {
  ExposureNow now;
  now.camera_name = trigger_.camera_name;
  now.number = trigger_.number;
  now.automatic = options_["exposureProgram"] != kManual;
  if (!now.automatic) {
    now.shutter_s = options_["shutterSpeed"].get<double>();
    now.iso = options_["iso"].get<int>();
  } else {
    const double wander = 2.0 * uniform_from_bits(hash_bits(trigger_.number)) - 1.0;
    const double ev =
        options_["exposureCompensation"].get<double>() + wander * settings_.automatic_wander_ev;
    now.iso = kMeteredIso;
    now.shutter_s = nearest_shutter(kMeteredShutter_s * std::exp2(ev));
  }
  now.gain = now.shutter_s * now.iso / (kMeteredShutter_s * kMeteredIso);
  return now;
}

// The file appears on the card, damaged where a fault says so. False: there is none.
bool SimulatedCamera::expose(const ExposureNow& exposure) {
  const WallTime taken_at =
      clock_->wall_now() + std::chrono::duration_cast<WallTime::duration>(
                               duration_from_ms(1000.0 * settings_.clock_offset_s));
  try {
    std::string jpeg = with_exif(source_(exposure), exposure, taken_at);
    if (faults_->occurs(RigFault::kEmptyPicture)) {
      jpeg.clear();
    } else if (faults_->occurs(RigFault::kTruncatedPicture)) {
      jpeg.resize(static_cast<std::size_t>(kKeptShare * static_cast<double>(jpeg.size())));
    }
    std::ofstream out(settings_.card_directory / exposure.camera_name, std::ios::binary);
    out.write(jpeg.data(), static_cast<std::streamsize>(jpeg.size()));
    out.close();
    if (!out) return false;
    const std::lock_guard lock(mutex_);
    used_bytes_ += static_cast<std::int64_t>(jpeg.size());
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

// Starts an exposure: the scene is that of now; the file can be fetched after exposure_ms.
Json SimulatedCamera::take_picture() {
  ExposureNow exposure;
  {
    const std::lock_guard lock(mutex_);
    require_idle();
    faults_->picture_triggered(triggers_ + 1);
    if (pictures_left() < 1 || faults_->occurs(RigFault::kCardFull)) {
      throw CommandRefused{"disabledCommand", "There is no room for another picture."};
    }
    if (faults_->occurs(RigFault::kForgetsExposure)) options_ = initial_options();
    trigger_ = {++triggers_, clock_->now(), faults_->occurs(RigFault::kBusy).has_value(), {}};
    if (!faults_->occurs(RigFault::kMissingPicture)) {
      trigger_.camera_name = fmt::format("R{:07}.JPG", ++last_number_);
    }
    exposure = exposure_now();
    rendering_ = true;
  }
  // Rendering takes long; the mutex is released so that the camera's state can be queried.
  const bool written = !exposure.camera_name.empty() && expose(exposure);
  const std::lock_guard lock(mutex_);
  rendering_ = false;
  if (!written) trigger_.camera_name.clear();
  return {{"state", "inProgress"},
          {"id", std::to_string(exposure.number)},
          {"progress", {{"completion", 0.0}}}};
}

std::uint64_t SimulatedCamera::pictures_taken() const {
  const std::lock_guard lock(mutex_);
  return triggers_;
}

void SimulatedCamera::restart() {
  const std::lock_guard lock(mutex_);
  trigger_ = Trigger{};
  options_ = initial_options();
}

std::int64_t SimulatedCamera::free_bytes() const {
  return std::max<std::int64_t>(settings_.card_bytes - used_bytes_, 0);
}

int SimulatedCamera::pictures_left() const {
  const std::lock_guard lock(mutex_);
  if (faults_->lasting(RigFault::kCardFull)) return 0;
  const std::int64_t left = free_bytes() / settings_.typical_picture_bytes;
  return static_cast<int>(std::min<std::int64_t>(left, 999'999));
}

std::string SimulatedCamera::file(const std::string& name) const {
  return read_file(settings_.card_directory / name);
}

}  // namespace raywalk::simulator
