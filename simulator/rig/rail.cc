#include "simulator/rig/rail.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

std::uint64_t key_of(int seed, const std::string& text) {
  std::uint64_t key = hash_bits(static_cast<std::uint64_t>(seed), 0x2a11);
  for (const char c : text) key = hash_bits(key, static_cast<unsigned char>(c));
  return key;
}

Eigen::Vector3d axis_of(LineAxis axis) {
  return axis == LineAxis::kX ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
}

// To the left as seen along the axis.
Eigen::Vector3d left_of(LineAxis axis) {
  return axis == LineAxis::kX ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(-1, 0, 0);
}

}  // namespace

Rail::Rail(const RailSettings& settings, const CapturePlan& plan, const RailSpan& span)
    : settings_(settings), span_(span) {
  if (!(span.low_mm < span.high_mm)) {
    throw Error(fmt::format("the simulated rail from {} to {} mm has no length", span.low_mm,
                            span.high_mm));
  }
  for (const CaptureLine& placement : capture::placements_of(plan)) {
    placings_[capture::placement_id(placement)] = placed(placement);
  }
}

Rail::Placing Rail::placed(const CaptureLine& line) const {
  const CaptureStation& first = line.stations.front();
  const CaptureStation& last = line.stations.back();
  const std::uint64_t key = key_of(settings_.seed, capture::placement_id(line));
  HashRandom random(key);
  const auto deviate_mm = [&] { return settings_.placing_spread_mm * random.normal(); };
  const auto deviate_rad = [&](double spread_deg) {
    return radians_from_degrees(spread_deg * random.normal());
  };
  Placing placing;
  placing.axis = line.axis;
  placing.middle_mm = 0.5 * (first.rail_mm + last.rail_mm);
  const Eigen::Vector3d planned_m(0.5 * (first.position_m.x_m + last.position_m.x_m), 0.0,
                                  0.5 * (first.position_m.z_m + last.position_m.z_m));
  for (int axis = 0; axis < 3; ++axis)
    placing.middle_m[axis] = planned_m[axis] + 1e-3 * deviate_mm();
  placing.direction_rad = deviate_rad(settings_.direction_spread_deg);
  placing.tilt_rad = deviate_rad(settings_.tilt_spread_deg);
  placing.camera.yaw_rad = deviate_rad(settings_.attitude_spread_deg);
  placing.camera.pitch_rad = deviate_rad(settings_.attitude_spread_deg);
  placing.camera.roll_rad = deviate_rad(settings_.attitude_spread_deg);
  placing.key = key;
  for (const CaptureStation& station : line.stations) {
    placing.stations_mm.push_back(station.rail_mm);
  }
  return placing;
}

double Rail::vibration_mm(double carriage_mm, std::optional<Duration> still_for,
                          std::uint64_t direction) const {
  const double t_s = still_for ? std::chrono::duration<double>(*still_for).count() : 0.0;
  const auto place = static_cast<std::uint64_t>(std::llround(1e3 * carriage_mm));
  const double phase =
      kTwoPi * uniform_from_bits(hash_bits(hash_bits(place, direction),
                                           static_cast<std::uint64_t>(settings_.seed)));
  const double decay = std::exp(-1e3 * t_s / settings_.vibration_decay_ms);
  return settings_.vibration_mm * decay * std::cos(kTwoPi * settings_.vibration_hz * t_s + phase);
}

// The rail's direction is its axis rotated by the yaw error and the tilt. Along x, an upward slope
// lifts the camera's right side (negative roll); along z it lifts its front (pitch). A bow of
// b (1 - u^2) to the left has the slope -2 b u / half in rail millimetres: a positive yaw, to the
// right, of 2 b u / half. Sag is the same downwards: an upward slope of 2 s u / half. Clockwise
// twist as seen along z is a roll; as seen along x it lifts the camera's front (pitch).
CameraPose Rail::carriage_pose(const std::string& line_id, double carriage_mm,
                               std::optional<Duration> still_for) const {
  const auto found = placings_.find(line_id);
  if (found == placings_.end()) {
    throw Error(fmt::format("the plan has no line {}", excerpt(line_id)));
  }
  const Placing& placing = found->second;
  const double half_mm = 0.5 * (span_.high_mm - span_.low_mm);
  const double u = (carriage_mm - span_.low_mm) / half_mm - 1.0;
  const double shape = 1.0 - u * u;
  const Eigen::Matrix3d turn = world_from_camera({placing.direction_rad, 0.0, 0.0});
  const Eigen::Vector3d level = turn * axis_of(placing.axis);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d along =
      std::cos(placing.tilt_rad) * level + std::sin(placing.tilt_rad) * up;
  CameraPose pose;
  const double along_mm = carriage_mm - placing.middle_mm + vibration_mm(carriage_mm, still_for, 0);
  const double up_mm = vibration_mm(carriage_mm, still_for, 1) - settings_.sag_mm * shape;
  pose.position_m =
      placing.middle_m + 1e-3 * (along_mm * along + up_mm * up +
                                 settings_.bow_mm * shape * (turn * left_of(placing.axis)));
  const double bow_slope = 2.0 * settings_.bow_mm * u / half_mm;
  const double rise_rad = placing.tilt_rad + std::atan(2.0 * settings_.sag_mm * u / half_mm);
  const double twist_rad = radians_from_degrees(0.5 * settings_.twist_deg * u);
  pose.attitude = placing.camera;
  pose.attitude.yaw_rad += placing.direction_rad + std::atan(bow_slope);
  if (placing.axis == LineAxis::kX) {
    pose.attitude.roll_rad -= rise_rad;
    pose.attitude.pitch_rad += twist_rad;
  } else {
    pose.attitude.pitch_rad += rise_rad;
    pose.attitude.roll_rad += twist_rad;
  }
  const auto& stations = placing.stations_mm;
  const auto nearest = std::min_element(stations.begin(), stations.end(), [&](double a, double b) {
    return std::abs(a - carriage_mm) < std::abs(b - carriage_mm);
  });
  add_jitter(settings_.jitter_mm, settings_.jitter_deg,
             HashRandom(placing.key)
                 .branch(static_cast<std::uint64_t>(std::distance(stations.begin(), nearest))),
             &pose);
  return pose;
}

}  // namespace raywalk::simulator
