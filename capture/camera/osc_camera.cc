#include "capture/camera/osc_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "capture/camera/check_picture.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

// Ricoh, camera.setOptions: "Leave an interval of 1 second or more between changing the settings"
// and camera.takePicture.
constexpr double kPauseAfterSetting_ms = 1000.0;
constexpr int kMostLostPictures = 2;  // while the exposure is measured

bool is_positive(const Json& object, const char* key) {
  return number_at(object, key).value_or(0.0) > 0.0;
}

bool contains(const Json& list, const char* word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

// None if it is not a number from 0 to 2^53, truncated to a whole number.
std::optional<std::int64_t> count_at(const Json& object, const char* key) {
  constexpr double kLargest = 9007199254740992.0;  // 2^53
  const double number = number_at(object, key).value_or(-1.0);
  if (!(number >= 0.0 && number <= kLargest)) return std::nullopt;
  return static_cast<std::int64_t>(number);
}

// The last part of a file's address.
std::string file_name(const std::string& file) { return file.substr(file.find_last_of('/') + 1); }

std::string shown_sizes(const Json& formats) {
  std::string sizes;
  for (const Json& format : formats) {
    const auto width = number_at(format, "width");
    const auto height = number_at(format, "height");
    if (!width || !height) continue;
    sizes += fmt::format("{}{:g}x{:g}", sizes.empty() ? "" : ", ", *width, *height);
  }
  return sizes;
}

std::string identity_in(const Json& info) {
  // Ricoh repeats the manufacturer in the model's name.
  const std::string manufacturer = text_at(info, "manufacturer");
  const bool repeated = text_at(info, "model").starts_with(manufacturer);
  std::string identity = repeated ? std::string{} : manufacturer;
  const auto append = [&](const std::string& separator, const std::string& text) {
    if (!text.empty()) identity += (identity.empty() ? "" : separator) + text;
  };
  append(" ", text_at(info, "model"));
  append(", serial ", text_at(info, "serialNumber"));
  append(", firmware ", text_at(info, "firmwareVersion"));
  return one_line(identity);
}

// "_captureStatus" and "_cameraError" are Ricoh's, "_cardState" is Insta360's.
std::string state_in(const Json& state) {
  std::string text = text_at(state, "_captureStatus");
  if (text.empty()) text = "ready";
  for (const Json& error : list_at(state, "_cameraError")) {
    if (error.is_string()) text += ", " + error.get<std::string>();
  }
  const std::string card = text_at(state, "_cardState");
  if (!card.empty() && card != "pass") text += ", card: " + card;
  return one_line(text);
}

}  // namespace

struct OscCamera::Options {
  Json supported = Json::object();  // exposure_option_names()
  Json lock;                        // at 0 EV; null without a lock
  Json set = Json::object();        // the options set last
};

OscCamera::OscCamera(const CameraConfig& config, Clock& clock)
    : config_(config),
      clock_(clock),
      client_(config.osc, clock),
      options_(std::make_unique<Options>()),
      frame_{config.width_px, config.height_px} {}

OscCamera::~OscCamera() = default;

std::string OscCamera::description() const { return "camera at " + client_.url(); }

SteadyTime OscCamera::deadline() const {
  return clock_.now() + duration_from_ms(config_.osc.picture_timeout_ms);
}

void OscCamera::sleep_poll() {
  throw_if_interrupted();
  clock_.sleep(duration_from_ms(std::max(config_.osc.poll_ms, 1.0)));
}

// For a camera that is busy until it is ready.
void OscCamera::sleep_poll(SteadyTime until, const std::string& detail) {
  if (clock_.now() >= until) throw busy_fault(detail);
  sleep_poll();
}

// A refusal that waiting does not resolve.
DeviceFault OscCamera::fault_of(const OscRefusal& refusal) const {
  return client_.fault(refusal.is_temporary() ? FaultKind::kBusy : FaultKind::kWrongDevice,
                       "the camera refuses the command" + refusal.in_parentheses() +
                           "; check its display, and close other programs that use it");
}

DeviceFault OscCamera::busy_fault(const std::string& detail) const {
  return client_.fault(FaultKind::kBusy,
                       fmt::format("the camera is still busy after {:g} s{}; switch it "
                                   "off and on, and close other programs that use it",
                                   config_.osc.picture_timeout_ms / 1000.0, detail));
}

// --- Report -------------------------------------------------------------------------------------

CameraReport osc_report(const Json& info, const Json& state, const Json& options) {
  CameraReport report;
  report.identity = identity_in(info);
  report.state = state_in(state);
  const auto battery = number_at(state, "batteryLevel");
  if (battery && *battery >= 0.0 && *battery <= 1.0) report.battery_share = battery;
  if (const auto pictures = count_at(options, "remainingPictures")) {
    report.pictures_left = static_cast<int>(std::min<std::int64_t>(*pictures, 1'000'000'000));
  }
  // Insta360's documentation shows 0 of 0 bytes for a camera that does not know.
  if (number_at(options, "totalSpace") != 0.0) {
    report.free_bytes = count_at(options, "remainingSpace");
  }
  return report;
}

bool reports_full_card(const Json& state, const Json& options) {
  return contains(list_at(state, "_cameraError"), "NO_MEMORY") ||
         text_at(state, "_cardState") == "noSpace" || count_at(options, "remainingPictures") == 0;
}

CameraReport OscCamera::report() {
  const Json info = client_.info();
  client_.open_session();
  const Json state = client_.state();
  try {
    return osc_report(info, state,
                      client_.options({"remainingPictures", "remainingSpace", "totalSpace"}));
  } catch (const OscRefusal& refusal) {
    CameraReport report = osc_report(info, state, Json::object());
    report.state += refusal.in_parentheses();
    return report;
  }
}

// --- Settings -----------------------------------------------------------------------------------

void OscCamera::set(const Json& options) {
  for (const SteadyTime until = deadline();;) {
    try {
      client_.set_options(options);
      set_at_ = clock_.now();
      return;
    } catch (const OscRefusal& refusal) {
      if (!refusal.is_temporary()) {
        throw client_.fault(FaultKind::kExposure,
                            "the camera refuses the settings " + options.dump() +
                                refusal.in_parentheses() +
                                "; change camera.exposure or set its lock to false");
      }
      sleep_poll(until, refusal.in_parentheses());
    }
  }
}

void OscCamera::choose_file_format() {
  const Json options = client_.options({"captureMode", "fileFormat", "fileFormatSupport",
                                        "photoStitching", "photoStitchingSupport"});
  if (text_at(options, "captureMode") != "image" && options.contains("captureMode")) {
    set({{"captureMode", "image"}});
  }
  // Insta360's cameras deliver panoramas or pairs of fisheye circles.
  const char* stitching = config_.frames == FrameKind::kPanorama ? "ondevice" : "none";
  if (contains(list_at(options, "photoStitchingSupport"), stitching) &&
      text_at(options, "photoStitching") != stitching) {
    set({{"photoStitching", stitching}});
  }
  const Json formats = list_at(options, "fileFormatSupport");
  if (config_.width_px <= 0 || formats.empty()) return;
  const Json wanted = {
      {"type", "jpeg"}, {"width", config_.width_px}, {"height", config_.height_px}};
  if (options.value("fileFormat", Json()) == wanted) return;
  if (std::find(formats.begin(), formats.end(), wanted) == formats.end()) {
    throw client_.fault(FaultKind::kWrongDevice,
                        fmt::format("the camera cannot take pictures of {}x{}, only of {}; change "
                                    "camera.width_px and camera.height_px",
                                    config_.width_px, config_.height_px, shown_sizes(formats)));
  }
  set({{"fileFormat", wanted}});
}

std::optional<ExifExposure> OscCamera::measured_exposure() {
  set({{"exposureProgram", 2}, {"whiteBalance", "auto"}});
  std::string bytes;
  for (int lost = 0; bytes.empty(); ++lost) {
    try {
      std::string taken = client_.fetch(take_picture().file);
      check_picture(taken, frame_, client_.url());
      bytes = std::move(taken);
    } catch (const DeviceFault& fault) {
      // The picture is of no station, so another one does as well.
      if (!fault.is_retryable() || lost >= kMostLostPictures) throw;
    }
  }
  if (const auto exposure = exif_exposure(bytes)) return exposure;
  // Ricoh's options are 0 in automatic mode; Insta360's hold the current values.
  const Json options = client_.options({"shutterSpeed", "iso"});
  constexpr double kLargestIso = 1e7;
  const double shutter_s = number_at(options, "shutterSpeed").value_or(0.0);
  const double iso = number_at(options, "iso").value_or(0.0);
  if (shutter_s <= 0.0 || iso < 1.0 || iso > kLargestIso) return std::nullopt;
  return ExifExposure{shutter_s, static_cast<int>(iso)};
}

Json OscCamera::chosen_lock(const ExposureSettings& exposure) {
  const bool complete = exposure.shutter_s > 0.0 && exposure.iso > 0;
  const auto measured = complete ? std::nullopt : measured_exposure();
  set({{"exposureProgram", 1}});
  const Json supported = client_.options(exposure_option_names());
  return locking_options(chosen_exposure(exposure, measured, supported), exposure.white_balance_k,
                         supported);
}

std::string OscCamera::prepare(const ExposureSettings& exposure, const std::string& earlier) {
  exposure_ = exposure;
  options_->lock = nullptr;
  options_->set = Json::object();
  client_.open_session();
  try {
    choose_file_format();
    if (!exposure.lock) {
      options_->supported = client_.options(exposure_option_names());
      return {};
    }
    const Json recorded = Json::parse(earlier, nullptr, false);
    if (!earlier.empty() && !(recorded.is_object() && is_positive(recorded, "shutterSpeed") &&
                              is_positive(recorded, "iso"))) {
      throw DeviceFault(FaultKind::kExposure, "the session's record of the exposure is damaged: " +
                                                  excerpt(earlier) + "; start a new session");
    }
    options_->lock = earlier.empty() ? chosen_lock(exposure) : recorded;
    options_->set = options_->lock;
    set(options_->set);
    // Ricoh lists the shutter times and sensitivities of the current exposureProgram only.
    options_->supported = client_.options(exposure_option_names());
    check_exposure();
    return options_->lock.dump();
  } catch (const OscRefusal& refusal) {
    throw fault_of(refusal);
  }
}

Json OscCamera::exposure_options(double ev) const {
  if (!options_->lock.is_null()) return bracketed(options_->lock, ev, options_->supported);
  const bool single = exposure_.bracket_ev.size() < 2 && ev == 0.0;
  if (single) return Json::object();
  return {{"exposureCompensation", nearest_compensation(options_->supported, ev)}};
}

// Reads back the options that were set, and what a picture says of its exposure.
void OscCamera::check_exposure(const std::optional<ExifExposure>& taken) {
  if (options_->set.empty()) return;
  std::vector<std::string> names;
  for (const auto& item : options_->set.items()) names.push_back(item.key());
  std::string what = "the camera does not keep its exposure: ";
  std::string broken = first_difference(options_->set, client_.options(names));
  if (broken.empty() && taken && options_->set.contains("shutterSpeed")) {
    what = "the picture is not exposed as set: ";
    broken = first_difference(options_->set, *taken);
  }
  if (broken.empty()) return;
  throw client_.fault(
      FaultKind::kExposure,
      what + broken + "; make sure that nobody changes its settings, then run again");
}

// --- Shooting -----------------------------------------------------------------------------------

Shot OscCamera::shoot(SteadyTime settled_at) {
  client_.open_session();
  while (clock_.now() < settled_at) sleep_poll();
  Shot shot;
  try {
    for (const double ev : exposure_.bracket_ev) shot.pictures.push_back(expose(ev, &shot));
  } catch (const OscRefusal& refusal) {
    throw fault_of(refusal);
  }
  return shot;
}

Picture OscCamera::expose(double ev, Shot* shot) {
  const Json wanted = exposure_options(ev);
  if (wanted != options_->set) {
    set(wanted);
    options_->set = wanted;
  }
  const Taken taken = take_picture();
  if (shot->pictures.empty()) shot->triggered_at = shot->exposed_at = taken.triggered_at;
  shot->exposing_ms += taken.exposing_ms;
  const SteadyTime fetching = clock_.now();
  Picture picture;
  picture.bytes = client_.fetch(taken.file);
  shot->transfer_ms += ms_from_duration(clock_.now() - fetching);
  picture.camera_name = file_name(taken.file);
  const CheckedPicture checked =
      check_picture(picture.bytes, frame_, client_.url() + ", " + picture.camera_name);
  frame_ = checked.size;
  picture.extension = checked.extension;
  picture.size = checked.size;
  const auto taken_with = exif_exposure(picture.bytes);
  check_exposure(taken_with);
  Json record = options_->set;
  if (taken_with && !record.contains("shutterSpeed")) {
    record["shutterSpeed"] = taken_with->shutter_s;
    record["iso"] = taken_with->iso;
  }
  if (!record.empty()) {
    record["ev"] = ev;
    picture.exposure = record.dump();
  }
  return picture;
}

OscCamera::Taken OscCamera::take_picture() {
  while (set_at_ && clock_.now() < *set_at_ + duration_from_ms(kPauseAfterSetting_ms)) sleep_poll();
  const SteadyTime until = deadline();
  for (bool is_woken = false;;) {
    Taken taken;
    taken.triggered_at = clock_.wall_now();
    const SteadyTime triggered = clock_.now();
    if (const auto command = begin_picture(until)) {
      taken.file = finished_file(*command, until);
      taken.exposing_ms = ms_from_duration(clock_.now() - triggered);
      return taken;
    }
    if (!is_woken && is_idle()) {
      // In standby a camera refuses to take pictures until its mode is set, even to the same.
      try {
        client_.set_options({{"captureMode", "image"}});
      } catch (const OscRefusal&) {
        // It is busy with something else, which is waited for.
      }
      is_woken = true;
    }
    sleep_poll();
  }
}

// None if the camera refuses temporarily.
std::optional<OscCommand> OscCamera::begin_picture(SteadyTime until) {
  try {
    return client_.begin_picture();
  } catch (const OscRefusal& refusal) {
    throw_if_card_full();
    if (!refusal.is_temporary()) throw;
    if (clock_.now() >= until) throw busy_fault(refusal.in_parentheses());
    return std::nullopt;
  } catch (const DeviceFault& lost) {
    if (lost.kind() != FaultKind::kNoContact) throw;
    while (!is_idle()) sleep_poll(until, "");
    throw client_.fault(
        FaultKind::kMissingPicture,
        "the answer to the trigger was lost, and with it the name of the picture; the "
        "station has to be shot again");
  }
}

bool OscCamera::is_idle() {
  const std::string status = text_at(client_.state(), "_captureStatus");
  return status.empty() || status == "idle";
}

std::string OscCamera::finished_file(OscCommand command, SteadyTime until) {
  while (!command.done) {
    sleep_poll(until, " with a picture");
    command = client_.status_of(command.id);
  }
  if (!command.file.empty()) return command.file;
  throw_if_card_full();
  throw client_.fault(FaultKind::kMissingPicture,
                      "the camera reports that it is done but took no picture; check its display");
}

void OscCamera::throw_if_card_full() {
  try {
    const Json state = client_.state();
    if (!reports_full_card(state, client_.options({"remainingPictures"}))) return;
  } catch (const OscRefusal&) {
    return;  // busy; the caller reports that
  }
  throw client_.fault(
      FaultKind::kCardFull,
      "the camera's card is full; copy and delete pictures on it or change the card, then "
      "run again");
}

}  // namespace raywalk::capture
