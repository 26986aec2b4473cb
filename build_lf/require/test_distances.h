// For tests: synthetic rooms with replaceable distances.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <vector>

#include "build_lf/pack/station_data.h"
#include "build_lf/pack/volume_writer.h"
#include "core/base/progress.h"
#include "core/files/test_support.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {

class RequireTest : public ::testing::Test {
 protected:
  Room room_of(const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, path_);
    return Room::open(path_);
  }

  // Replaces every distance of the room by change(metres), with the given confidence.
  void replace_distances(const std::function<float(float)>& change,
                         std::uint8_t confidence = 255) const {
    const Room room = Room::open(path_);
    Progress progress("replacing", 1, "maps");
    for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
      const DistanceVolume& volume = room.distances(line);
      const std::vector<std::int32_t> stations(volume.stations().begin(), volume.stations().end());
      std::vector<StationDistances> maps;  // made one after the other: `change` may be random
      for (int map = 0; map < volume.maps(); ++map) {
        StationDistances changed = stored_distances(volume, map);
        for (float& metres : changed.distance_m) metres = change(metres);
        changed.confidence.assign(changed.distance_m.size(), confidence);
        changed.sha256 = checksum_of_distances(changed.distance_m, changed.confidence);
        maps.push_back(std::move(changed));
      }
      const Line& of_line = room.grid().lines[line];
      write_distance_volume(
          distance_volume_path(path_, of_line.id), of_line,
          {stations, volume.size(), "changed", [&](std::size_t i) { return maps[i]; }}, &progress);
    }
  }

  TestDirectory directory_;
  std::filesystem::path path_ = directory_ / "room.lf";
};

}  // namespace raywalk::build_lf
