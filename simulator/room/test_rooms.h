// For tests: settings of an empty and a furnished room.
#pragma once

#include "simulator/room/room_settings.h"

namespace raywalk::capture {

// Only floor, ceiling and four walls: a box, whose distances are known in closed form.
inline VirtualRoomSettings empty_room(int seed, double cell_side_m) {
  VirtualRoomSettings settings;
  settings.seed = seed;
  settings.grid.cell_side_m = cell_side_m;
  ContentSettings& contents = settings.contents;
  contents.chairs = contents.pictures = 0;
  contents.table = contents.shelf = contents.sofa = contents.rug = contents.plant = false;
  contents.coat_stand = contents.lamp = contents.beams = contents.skirting = false;
  contents.mirror = false;
  contents.window = contents.sun_patch = contents.wallpaper = contents.plain_patch = false;
  return settings;
}

inline VirtualRoomSettings furnished_room(int seed, double cell_side_m = 1.0) {
  VirtualRoomSettings settings;
  settings.seed = seed;
  settings.grid.cell_side_m = cell_side_m;
  return settings;
}

}  // namespace raywalk::capture
