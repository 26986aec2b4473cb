#include "simulator/room/station_picture.h"

#include <vector>

#include "simulator/room/camera_ring.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/sensor.h"

namespace raywalk::capture {
namespace {

cv::Mat ring_picture(const VirtualRoom& room, const RoomStation& station, int moment,
                     PanoramaSize size) {
  const VirtualRoomSettings& settings = room.settings();
  const std::vector<double> gains = ring_gains(settings.ring, settings.seed, moment);
  const auto seen_by = [&](RingRays::Camera camera, std::uint64_t noise_key) {
    const cv::Mat seen =
        room.picture_with_people(moment, RingRays(settings.ring, size, camera), station.true_pose);
    return apply_sensor(seen, settings.sensor, station.gain, noise_key,
                        ring_light(settings.ring, gains, size, camera));
  };
  cv::Mat own = seen_by(RingRays::Camera::kOwn, station.noise_key);
  if (settings.ring.feather_deg == 0.0) return own;
  return stitched(settings.ring, own,
                  seen_by(RingRays::Camera::kOther, hash_bits(station.noise_key)));
}

}  // namespace

cv::Mat station_picture(const VirtualRoom& room, const RoomStation& station, int moment,
                        PanoramaSize size) {
  if (room.settings().ring.cameras > 0) return ring_picture(room, station, moment, size);
  return apply_sensor(room.panorama_with_people(moment, station.true_pose, size),
                      room.settings().sensor, station.gain, station.noise_key);
}

}  // namespace raywalk::capture
