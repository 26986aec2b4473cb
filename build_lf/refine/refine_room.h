// Develops a captured room into few stations, each better than any photograph: `raywalk-build-lf
// refine`.
#pragma once

#include <filesystem>

#include "core/room/ray_form.h"

namespace raywalk::build_lf {

struct RefineOptions {
  std::filesystem::path room;
  std::filesystem::path out;  // the room directory to create
  int stations = 0;           // stations_to_develop()
  int width = 0;              // developed_width()
  int hold_out = 0;           // every how many-th captured station is left out; 0: none
  RayForm form{};             // how the developed pictures are stored
  bool replace = false;       // a room at `out` is replaced
};

// Creates the refined room, a room like any other, which appears only when complete. A stopped run
// is resumed by the same command: what is developed is kept in `<out>.partial`. Throws UsageError
// for options out of range; Error as Room::open and pack_room do, and if the room has no distances
// or is itself a refined one.
void refine_room(const RefineOptions& options);

}  // namespace raywalk::build_lf
