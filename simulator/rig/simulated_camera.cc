#include "simulator/rig/simulated_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "simulator/rig/exif_segment.h"
#include "simulator/room/hash_random.h"

namespace raywalk::capture {
namespace {

constexpr int kManual = 1;
constexpr int kAutomatic = 2;
constexpr double kKeptShare = 0.6;  // of a truncated picture's bytes
constexpr int kMinTemperature_k = 2500;
constexpr int kMaxTemperature_k = 10000;
constexpr int kTemperatureStep_k = 100;

// Tolerates the rounding of numbers that clients send back in decimal.
bool same_number(double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(b); }

double nearest(const std::vector<double>& values, double wanted) {
  return *std::min_element(values.begin(), values.end(), [&](double a, double b) {
    return std::abs(std::log(a / wanted)) < std::abs(std::log(b / wanted));
  });
}

CommandRefused unsupported(const std::string& option) {
  return {"invalidParameterValue", "The value of " + option + " is not supported."};
}

void check_exposure(const CameraOptions& options) {
  const CameraSupport& support = camera_support();
  const auto has_shutter = [&](double value) { return same_number(value, options.shutter_s); };
  if (std::none_of(support.shutter_s.begin(), support.shutter_s.end(), has_shutter)) {
    throw unsupported("shutterSpeed");
  }
  if (std::find(support.iso.begin(), support.iso.end(), options.iso) == support.iso.end()) {
    throw unsupported("iso");
  }
}

void check_white_balance(const CameraOptions& options) {
  const std::vector<std::string>& known = camera_support().white_balance;
  if (std::find(known.begin(), known.end(), options.white_balance) == known.end()) {
    throw unsupported("whiteBalance");
  }
  const int temperature_k = options.color_temperature_k;
  if (temperature_k < kMinTemperature_k || temperature_k > kMaxTemperature_k ||
      temperature_k % kTemperatureStep_k != 0) {
    throw unsupported("_colorTemperature");
  }
}

std::string at_half_size(const std::string& jpeg) {
  const cv::Mat bytes(1, static_cast<int>(jpeg.size()), CV_8UC1,
                      const_cast<char*>(jpeg.data()));  // OpenCV does not write to it
  const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_COLOR);
  if (image.empty()) return jpeg;
  cv::Mat half;
  cv::resize(image, half, cv::Size(std::max(1, image.cols / 2), std::max(1, image.rows / 2)));
  std::vector<unsigned char> encoded;
  cv::imencode(".jpg", half, encoded);
  return {encoded.begin(), encoded.end()};
}

}  // namespace

const CameraSupport& camera_support() {
  // Of the Ricoh Theta V and Z1 (Web API v2.1, shutterSpeed, iso, exposureCompensation); slower
  // than a second is left out.
  static const CameraSupport support{
      {0.00004, 0.00005,    0.0000625, 0.00008, 0.0001,     0.000125,   0.00015625,
       0.0002,  0.00025,    0.0003125, 0.0004,  0.0005,     0.000625,   0.0008,
       0.001,   0.00125,    0.0015625, 0.002,   0.0025,     0.003125,   0.004,
       0.005,   0.00625,    0.008,     0.01,    0.0125,     0.01666666, 0.02,
       0.025,   0.03333333, 0.04,      0.05,    0.06666666, 0.07692307, 0.1,
       0.125,   0.16666666, 0.2,       0.25,    0.33333333, 0.4,        0.5,
       0.625,   0.76923076, 1.0},
      {80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250, 1600, 2000, 2500, 3200},
      {-2.0, -1.7, -1.3, -1.0, -0.7, -0.3, 0.0, 0.3, 0.7, 1.0, 1.3, 1.7, 2.0},
      {"auto", "daylight", "shade", "cloudy-daylight", "incandescent", "fluorescent",
       "_colorTemperature"}};
  return support;
}

SimulatedCamera::SimulatedCamera(SimulatedCameraSettings settings, const Clock& clock,
                                 PictureSource source)
    : settings_(std::move(settings)),
      clock_(clock),
      source_(std::move(source)),
      faults_(clock),
      card_(settings_.card_directory, settings_.card_bytes) {}

CameraOptions SimulatedCamera::options() const {
  const std::lock_guard lock(mutex_);
  return options_;
}

void SimulatedCamera::set_options(const CameraOptions& options) {
  const std::lock_guard lock(mutex_);
  if (is_exposing_locked()) {
    throw CommandRefused("disabledCommand", "The camera is shooting.");
  }
  CameraOptions taken = options;
  check_white_balance(options);
  if (options.exposure_program == kManual) {
    // On leaving automatic exposure, unset values start from the metered ones.
    if (taken.shutter_s == 0.0) {
      taken.shutter_s = nearest(camera_support().shutter_s, settings_.metered_shutter_s);
    }
    if (taken.iso == 0) taken.iso = settings_.metered_iso;
    check_exposure(taken);
    taken.compensation_ev = 0.0;
  } else if (options.exposure_program == kAutomatic) {
    taken.shutter_s = 0.0;
    taken.iso = 0;
    const std::vector<double>& known = camera_support().compensation_ev;
    if (std::find(known.begin(), known.end(), options.compensation_ev) == known.end()) {
      throw unsupported("exposureCompensation");
    }
  } else {
    throw unsupported("exposureProgram");
  }
  options_ = taken;
}

bool SimulatedCamera::is_exposing_locked() const {
  if (trigger_.number == 0) return false;
  return rendering_ || trigger_.stuck || (trigger_.held && faults_.lasts(CameraFault::kBusy)) ||
         clock_.now() < trigger_.started + duration_from_ms(settings_.exposure_ms);
}

bool SimulatedCamera::is_exposing() const {
  const std::lock_guard lock(mutex_);
  return is_exposing_locked();
}

SimulatedCamera::Trigger SimulatedCamera::begin_locked() {
  if (is_exposing_locked()) {
    throw CommandRefused("disabledCommand", "The camera is shooting.");
  }
  const std::uint64_t number = triggers_ + 1;
  if (pictures_left() < 1 || faults_.occurs_at_picture(CameraFault::kCardFull, number)) {
    throw CommandRefused("disabledCommand", "There is no room for another picture.");
  }
  triggers_ = number;
  if (faults_.occurs_at_picture(CameraFault::kForgetsExposure, number)) options_ = CameraOptions{};
  Trigger trigger;
  trigger.number = number;
  trigger.started = clock_.now();
  const bool lasting = faults_.lasts(CameraFault::kBusy);
  if (faults_.occurs_at_picture(CameraFault::kBusy, number)) {
    (lasting ? trigger.held : trigger.stuck) = true;
  }
  if (!faults_.occurs_at_picture(CameraFault::kMissingPicture, number)) {
    trigger.camera_name = card_.next_name();
  }
  return trigger;
}

ExposureNow SimulatedCamera::exposure_locked(const Trigger& trigger) const {
  ExposureNow now;
  now.camera_name = trigger.camera_name;
  now.number = trigger.number;
  const double asked = settings_.metered_shutter_s * settings_.metered_iso;
  if (options_.exposure_program == kManual) {
    now.shutter_s = options_.shutter_s;
    now.iso = options_.iso;
  } else {
    const double wander = 2.0 * uniform_from_bits(hash_bits(trigger.number)) - 1.0;
    const double ev = options_.compensation_ev + wander * settings_.automatic_wander_ev;
    now.iso = settings_.metered_iso;
    now.shutter_s =
        nearest(camera_support().shutter_s, settings_.metered_shutter_s * std::exp2(ev));
  }
  now.gain = now.shutter_s * now.iso / asked;
  now.white_balance_k = options_.white_balance == "_colorTemperature"
                            ? options_.color_temperature_k
                            : settings_.metered_white_balance_k;
  return now;
}

std::string SimulatedCamera::damaged(const std::string& jpeg, std::uint64_t number) {
  if (faults_.occurs_at_picture(CameraFault::kEmptyPicture, number)) return {};
  if (faults_.occurs_at_picture(CameraFault::kTruncatedPicture, number)) {
    return jpeg.substr(0, static_cast<std::size_t>(kKeptShare * static_cast<double>(jpeg.size())));
  }
  if (faults_.occurs_at_picture(CameraFault::kWrongSize, number)) return at_half_size(jpeg);
  return jpeg;
}

bool SimulatedCamera::expose(const ExposureNow& exposure) {
  const WallTime taken_at = wall_now();
  const bool automatic = options().exposure_program != kManual;
  try {
    const PictureExif exif{settings_.model, taken_at, exposure.shutter_s, exposure.iso, automatic};
    card_.write(exposure.camera_name, damaged(with_exif(source_(exposure), exif), exposure.number));
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

std::string SimulatedCamera::take_picture() {
  ExposureNow exposure;
  {
    const std::lock_guard lock(mutex_);
    const Trigger trigger = begin_locked();
    if (!trigger_.camera_name.empty()) file_before_ = trigger_.camera_name;
    trigger_ = trigger;
    exposure = exposure_locked(trigger);
    rendering_ = true;
  }
  // Rendering takes long; the mutex is released so that the camera's state can be queried.
  const bool written = !exposure.camera_name.empty() && expose(exposure);
  const std::lock_guard lock(mutex_);
  rendering_ = false;
  if (!written) trigger_.camera_name.clear();
  return std::to_string(exposure.number);
}

PictureProgress SimulatedCamera::progress_of(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  if (trigger_.number == 0 || id != std::to_string(trigger_.number)) {
    throw CommandRefused("invalidParameterValue", "There is no command with this id.");
  }
  if (!is_exposing_locked()) return {true, 1.0, trigger_.camera_name};
  const double passed_ms = ms_from_duration(clock_.now() - trigger_.started);
  return {false, std::clamp(passed_ms / std::max(settings_.exposure_ms, 1.0), 0.0, 0.99), {}};
}

std::uint64_t SimulatedCamera::pictures_taken() const {
  const std::lock_guard lock(mutex_);
  return triggers_;
}

std::string SimulatedCamera::last_file() const {
  const std::lock_guard lock(mutex_);
  return is_exposing_locked() || trigger_.camera_name.empty() ? file_before_ : trigger_.camera_name;
}

int SimulatedCamera::pictures_left() const {
  if (faults_.lasts(CameraFault::kCardFull)) return 0;
  const std::int64_t left =
      card_.free_bytes() / std::max<std::int64_t>(settings_.typical_picture_bytes, 1);
  return static_cast<int>(std::min<std::int64_t>(left, 999'999));
}

void SimulatedCamera::restart() {
  const std::lock_guard lock(mutex_);
  faults_.clear();
  if (!trigger_.camera_name.empty()) file_before_ = trigger_.camera_name;
  trigger_ = Trigger{};
  options_ = CameraOptions{};
}

WallTime SimulatedCamera::wall_now() const {
  return clock_.wall_now() + std::chrono::duration_cast<WallTime::duration>(
                                 duration_from_ms(1000.0 * settings_.clock_offset_s));
}

}  // namespace raywalk::capture
