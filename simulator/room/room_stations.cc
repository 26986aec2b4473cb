#include "simulator/room/room_stations.h"

#include <fmt/format.h>

#include <algorithm>

#include "simulator/room/hash_random.h"

namespace raywalk::capture {
namespace {

CameraPose jittered(const CameraPose& nominal, const PoseSettings& jitter, HashRandom random) {
  const double position_m = jitter.position_jitter_mm * 1e-3;
  const double angle_rad = radians_from_degrees(jitter.attitude_jitter_deg);
  CameraPose pose = nominal;
  for (int axis = 0; axis < 3; ++axis) pose.position_m[axis] += position_m * random.normal();
  pose.attitude.yaw_rad += angle_rad * random.normal();
  pose.attitude.pitch_rad += angle_rad * random.normal();
  pose.attitude.roll_rad += angle_rad * random.normal();
  return pose;
}

}  // namespace

std::vector<RoomStation> room_stations(const RoomPlan& plan, const VirtualRoomSettings& settings) {
  const HashRandom all(hash_bits(static_cast<std::uint64_t>(settings.seed), 0x57a7));
  std::vector<RoomStation> stations;
  for (const PlannedLine& line : plan.lines) {
    for (std::size_t i = 0; i < line.along.size(); ++i) {
      HashRandom random = all.branch(stations.size());
      RoomStation station;
      station.line = line.id;
      station.name = fmt::format("{}_{:03}", line.id, i);
      station.number = static_cast<int>(i);
      station.nominal.position_m = plan.unit_m * line.position(line.along[i]);
      station.gain = std::clamp(1.0 + settings.sensor.gain_spread * random.normal(), 0.25, 4.0);
      station.noise_key = random.bits();
      station.true_pose = jittered(station.nominal, settings.pose, random.branch(0));
      stations.push_back(station);
    }
  }
  return stations;
}

}  // namespace raywalk::capture
