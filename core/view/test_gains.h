// For tests: a synthetic room whose stations have gains.
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

// A room with gains, not all of them 1.
class RoomWithGains {
 public:
  RoomWithGains(const SyntheticRoomSpec& spec,
                const std::function<GainField(int line, int station)>& gains) {
    const auto path = directory_ / "room.lf";
    write_synthetic_room(spec, path);
    RoomManifest manifest = read_manifest(path);
    GainFields fields = unit_gain_fields(manifest.grid);
    for (std::size_t line = 0; line < fields.size(); ++line) {
      for (std::size_t station = 0; station < fields[line].size(); ++station) {
        fields[line][station] = gains(static_cast<int>(line), static_cast<int>(station));
      }
    }
    write_gain_fields(gains_path(path), manifest.grid, fields);
    manifest.gains = true;
    write_file_atomically(manifest_path(path), manifest_to_json(manifest));
    room_ = Room::open(path);
  }
  const Room& room() const { return room_; }

 private:
  TestDirectory directory_;
  Room room_;
};

// Other gains in every patch of every station but the first.
inline GainField random_field(int line, int station) {
  GainField field;
  if (line == 0 && station == 0) return field;  // exactly 1
  cv::RNG random(static_cast<std::uint64_t>(100 * line + station));
  field.local.create(12, 6, CV_32FC3);
  random.fill(field.local, cv::RNG::UNIFORM, 0.7, 1.3);
  return field;
}

}  // namespace raywalk
