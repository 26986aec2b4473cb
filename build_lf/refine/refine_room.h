// Develops a captured room into few stations, each better than any photograph: `raywalk-build-lf
// refine`.
#pragma once

#include <filesystem>
#include <string>

#include "build_lf/pack/work_part.h"
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

// Develops the stations of one part into `<out>.partial`, which parts on any machines share;
// refine_room() then develops what is missing and makes the room. Throws as refine_room(). Returns
// what was done, a line.
std::string refine_part(const RefineOptions& options, WorkPart part);

}  // namespace raywalk::build_lf
