#include "capture/camera/v4l2_exposure.h"

#include <linux/v4l2-controls.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

// V4L2_CID_EXPOSURE_ABSOLUTE counts 100 us.
constexpr double kExposuresPerSecond = 1e4;

// A control and the mode whose automatic changes it.
struct LockedPair {
  VideoControl value;
  VideoControl mode;
  std::vector<int> modes_on;  // values that switch the automatic on, in order of preference
  int mode_off;
};

// The automatic of most webcams is aperture priority (their aperture is fixed).
const std::array<LockedPair, 3>& locked_pairs() {
  static const std::array<LockedPair, 3> pairs = {
      LockedPair{VideoControl::kExposure,
                 VideoControl::kExposureMode,
                 {V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_AUTO},
                 V4L2_EXPOSURE_MANUAL},
      LockedPair{VideoControl::kGain, VideoControl::kAutoGain, {1}, 0},
      LockedPair{VideoControl::kWhiteBalance, VideoControl::kAutoWhiteBalance, {1}, 0}};
  return pairs;
}

// Of a number from outside; the control's own range is looked at when it is set.
int as_control(double value) { return static_cast<int>(std::lround(std::clamp(value, 0.0, 2e9))); }

}  // namespace

bool is_bracketed(std::span<const double> bracket_ev) {
  return bracket_ev.size() > 1 || (bracket_ev.size() == 1 && bracket_ev.front() != 0.0);
}

std::string V4l2Exposure::lock(const ExposureSettings& settings, const std::string& earlier,
                               const std::function<void()>& measure) {
  if (settings.iso != 0) {
    throw UsageError(
        "V4L2 cameras have a gain rather than ISO; set camera.exposure.iso to 0, and the gain that "
        "the camera chooses is locked");
  }
  locked_.clear();
  off_.clear();
  if (!settings.lock) {
    if (!is_bracketed(settings.bracket_ev)) return "";
    throw UsageError("camera.exposure.bracket_ev needs camera.exposure.lock to be true");
  }
  const Values wanted = wanted_values(settings, earlier);
  if (earlier.empty() && switch_on_automatics(wanted)) measure();
  fix_values(wanted);
  if (locked_.contains(VideoControl::kExposure)) {
    base_exposure_ = locked_.at(VideoControl::kExposure);
  }
  // Checks now, and not during the session, that the bracket is within the camera's range.
  if (is_bracketed(settings.bracket_ev)) {
    for (const double ev : settings.bracket_ev) bracketed(ev);
  }
  return confirm();
}

// Switches on the automatics of all controls without a value. Returns whether there are any.
bool V4l2Exposure::switch_on_automatics(const Values& wanted) {
  bool any = false;
  for (const LockedPair& pair : locked_pairs()) {
    if (wanted.contains(pair.value) || !device_->range_of(pair.mode)) continue;
    const bool is_on = std::any_of(pair.modes_on.begin(), pair.modes_on.end(),
                                   [&](int mode) { return device_->set_control(pair.mode, mode); });
    if (!is_on) {
      throw fault("refuses to measure " + name_of(pair.value) +
                  " by itself; give its value in camera.exposure");
    }
    any = true;
  }
  return any;
}

void V4l2Exposure::fix_values(const Values& wanted) {
  for (const LockedPair& pair : locked_pairs()) {
    const std::optional<ControlRange> range = device_->range_of(pair.value);
    const auto given = wanted.find(pair.value);
    if (!range && given != wanted.end()) {
      throw fault("has no control for " + name_of(pair.value) +
                  "; leave its key of camera.exposure at 0");
    }
    // Reads it while the automatic is still on.
    std::optional<int> value;
    if (given != wanted.end()) {
      value = given->second;
    } else if (range) {
      value = std::clamp(device_->control(pair.value), range->least, range->most);
    }
    if (device_->range_of(pair.mode)) switch_off(pair.mode, pair.mode_off);
    if (value) hold(pair.value, *value);
  }
}

void V4l2Exposure::switch_off(VideoControl mode, int value_off) {
  if (!device_->set_control(mode, value_off)) {
    throw fault("refuses to switch " + name_of(mode) +
                " off; set camera.exposure.lock to false, or use another camera");
  }
  expect(mode, value_off, 0);
  off_[mode] = value_off;
}

V4l2Exposure::Values V4l2Exposure::wanted_values(const ExposureSettings& settings,
                                                 const std::string& earlier) const {
  Values wanted;
  if (earlier.empty()) {
    if (settings.shutter_s > 0.0) {
      wanted[VideoControl::kExposure] = as_control(settings.shutter_s * kExposuresPerSecond);
    }
    if (settings.white_balance_k > 0) {
      wanted[VideoControl::kWhiteBalance] = settings.white_balance_k;
    }
    return wanted;
  }
  const nlohmann::json values = nlohmann::json::parse(earlier, nullptr, false);
  for (const LockedPair& pair : locked_pairs()) {
    if (!values.is_object() || !values.contains(name_of(pair.value))) continue;
    const nlohmann::json& value = values.at(name_of(pair.value));
    if (value.is_number_integer()) wanted[pair.value] = as_control(value.get<double>());
  }
  if (wanted.empty()) {
    throw fault(
        "was locked by this session to " + excerpt(earlier) +
        ", which are not settings of a V4L2 camera; resume with the camera it was started with");
  }
  return wanted;
}

// Drivers round to their steps; a difference of more than one step is an error.
void V4l2Exposure::hold(VideoControl control, int value) {
  const ControlRange range = device_->range_of(control).value_or(ControlRange{});
  if (value < range.least || value > range.most) {
    throw fault("takes " + name_of(control) + " from " + std::to_string(range.least) + " to " +
                std::to_string(range.most) + ", not " + std::to_string(value) +
                "; correct camera.exposure");
  }
  if (!device_->set_control(control, value)) {
    throw fault("refuses " + name_of(control) + " " + std::to_string(value) +
                "; correct camera.exposure");
  }
  expect(control, value, range.step);
  locked_[control] = device_->control(control);
}

void V4l2Exposure::expect(VideoControl control, int wanted, int tolerance) {
  const int held = device_->control(control);
  if (std::abs(static_cast<double>(held) - wanted) <= tolerance) return;
  throw fault("has " + name_of(control) + " at " + std::to_string(held) + " and not at the " +
              std::to_string(wanted) +
              " that was set; make sure that no other program changes it, and resume");
}

int V4l2Exposure::bracketed(double ev) {
  const std::optional<ControlRange> range = device_->range_of(VideoControl::kExposure);
  if (!range) {
    throw fault("has no control for the exposure; set camera.exposure.bracket_ev to [0]");
  }
  const double value = std::round(base_exposure_ * std::exp2(ev));
  // Negated, so that NaN is refused too.
  if (!(value >= range->least && value <= range->most)) {
    throw fault("cannot expose by " + std::to_string(ev) + " EV from " +
                std::to_string(base_exposure_ / kExposuresPerSecond) + " s, since it takes " +
                std::to_string(range->least / kExposuresPerSecond) + " to " +
                std::to_string(range->most / kExposuresPerSecond) +
                " s; correct camera.exposure.bracket_ev");
  }
  return static_cast<int>(value);
}

void V4l2Exposure::bracket(double ev) { hold(VideoControl::kExposure, bracketed(ev)); }

Duration V4l2Exposure::locked_time() const {
  const auto exposure = locked_.find(VideoControl::kExposure);
  if (exposure == locked_.end()) return Duration::zero();
  return duration_from_ms(1000.0 * exposure->second / kExposuresPerSecond);
}

std::string V4l2Exposure::confirm() {
  for (const auto& [control, value] : off_) expect(control, value, 0);
  nlohmann::json values = nlohmann::json::object();
  for (const auto& [control, value] : locked_) {
    expect(control, value, 0);
    values[name_of(control)] = value;
  }
  return values.empty() ? "" : values.dump();
}

DeviceFault V4l2Exposure::fault(const std::string& what) const {
  return {FaultKind::kExposure, "camera " + device_->path() + " " + what};
}

}  // namespace raywalk::capture
