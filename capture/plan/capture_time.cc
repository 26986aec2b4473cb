#include "capture/plan/capture_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/number_text.h"

namespace raywalk::capture {
namespace {

constexpr double kSecondsPerMillisecond = 1e-3;
// From the command until the picture is ready, and its transfer over Wi-Fi. Cameras with the Open
// Spherical Camera API develop and stitch for some seconds; they differ, hence run.picture_s.
constexpr double kOscPicture_s = 5.0;
// Exposure and writing of a camera with a busy line.
constexpr double kBusyCamera_s = 1.5;

double one_shot_of_gpio_s(const TriggerConfig& trigger) {
  const double pressed_s = (trigger.focus_ms + trigger.pulse_ms) * kSecondsPerMillisecond;
  return pressed_s +
         (trigger.busy_line < 0 ? trigger.hold_ms * kSecondsPerMillisecond : kBusyCamera_s);
}

double one_exposure_s(const CameraConfig& camera) {
  switch (camera.kind) {
    case CameraKind::kOsc:
      return kOscPicture_s + camera.exposure.shutter_s;
    case CameraKind::kGpio:
      return one_shot_of_gpio_s(camera.trigger);
    case CameraKind::kV4l2:
      // A frame that started before the carriage settled is dropped; the next one is taken.
      return 2.0 * camera.v4l2.exposure_ms * kSecondsPerMillisecond;
  }
  throw std::logic_error("unknown kind of camera");
}

// Of a move of `distance_mm` >= 0 from rest to rest.
double move_s(double distance_mm, const MotionProfile& profile) {
  return profile.moving_ms(distance_mm) * kSecondsPerMillisecond;
}

// The position from which the first station of a line is approached.
double approach_mm(const CaptureLine& line, const CaptureConfig& config) {
  return std::max(config.slider.low_limit_mm,
                  line.stations.front().rail_mm - config.run.approach_mm);
}

// One pass without a stop.
double video_s(const CaptureLine& line, const CaptureConfig& config) {
  const MotionProfile pass{config.run.video_speed_mm_s,
                           config.slider.motion.profile.acceleration_mm_s2};
  return move_s(line.stations.back().rail_mm - approach_mm(line, config), pass);
}

double station_moves_s(const CaptureLine& line, const CaptureConfig& config) {
  double seconds = 0.0;
  double at_mm = approach_mm(line, config);
  for (const CaptureStation& station : line.stations) {
    seconds += move_s(station.rail_mm - at_mm, config.slider.motion.profile);
    at_mm = station.rail_mm;
  }
  return seconds;
}

}  // namespace

double picture_s(const CaptureConfig& config) {
  const CameraConfig& camera = config.camera;
  const auto exposures = static_cast<double>(camera.exposure.bracket_ev.size());
  if (config.run.picture_s > 0.0) return exposures * config.run.picture_s;
  const bool at_one_press = camera.kind == CameraKind::kGpio && !camera.trigger.press_per_exposure;
  return (at_one_press ? 1.0 : exposures) * one_exposure_s(camera);
}

double homing_s(const CaptureConfig& config) {
  const SliderConfig& slider = config.slider;
  return move_s(slider.high_limit_mm - slider.low_limit_mm, slider.motion.profile);
}

CaptureTime estimate_time(const CapturePlan& plan, const CaptureConfig& config) {
  const SliderConfig& slider = config.slider;
  const MotionRules& motion = slider.motion;
  const bool video = config.run.mode == CaptureMode::kVideo;
  CaptureTime time;
  time.motion_s = homing_s(config);
  double at_mm = slider.low_limit_mm;
  const std::vector<CaptureLine> placements = placements_of(plan);
  for (const CaptureLine& line : placements) {
    time.motion_s += move_s(std::abs(at_mm - approach_mm(line, config)), motion.profile);
    time.motion_s += video ? video_s(line, config) : station_moves_s(line, config);
    const double stops = video ? 2.0 : static_cast<double>(line.stations.size()) + 1.0;
    time.settling_s += stops * motion.settle_ms * kSecondsPerMillisecond;
    at_mm = line.stations.back().rail_mm;
  }
  if (!video) time.pictures_s = static_cast<double>(plan.stations()) * picture_s(config);
  time.placing_s = static_cast<double>(placements.size()) * config.run.placing_s;
  return time;
}

std::string duration_text(double seconds) {
  const long whole_s = std::lround(seconds);
  if (whole_s < 60) return fmt::format("{} s", plain_number(seconds, seconds < 10.0 ? 1 : 0));
  const long minutes = (whole_s + 30) / 60;
  if (minutes < 60) return fmt::format("{} min", minutes);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

}  // namespace raywalk::capture
