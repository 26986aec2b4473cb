// What an export holds: which of a room's stations, and how wide.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/room/requirements.h"
#include "core/room/room.h"
#include "core/view/connection.h"

namespace raywalk::render {

struct WebDemand {
  double budget_mb = 256.0;  // 10^6 bytes of GPU memory; > 0
  int width_px = 0;          // of the panoramas, at most; 0: no limit
  ConnectionRule rule{};
};

struct WebPlan {
  KeptStations kept{};
  int stations = 0;           // how many these are
  int captured_stations = 0;  // of the room
  int width = 0;              // of the panoramas, a multiple of 4
  int distance_width = 0;     // of the distances, a multiple of 4
  int resident_stations = 0;  // of the cell that is read from most of them
  std::string summary{};      // lines for the user: what was chosen and why
};

// Width of the coarse panoramas beside panoramas of a width (a multiple of 4): 256, or half of it.
int coarse_width_of(int width);

// GPU memory of stations, 10^6 bytes: four bytes per pixel of a panorama and of the coarse one, two
// per distance. The page counts alike (src/field/station_textures.ts).
double gpu_mb(int stations, int width, int distance_width);

// The stations that the views in one cell are read from, at least a tenth of it away from its
// sides: the most of any cell, from the first to the last of each line. All stations where no lines
// close a cell.
int most_stations_of_a_cell(const Grid& grid, const ConnectionRule& rule);

// Keeps the stations that the room's scene requires, as `raywalk-build-lf require` measured, or all
// where it was not run. The width is that of the panoramas, of what the scene's distances are
// accurate enough for, and of the demand, whichever is smallest; that of the distances what the
// scene requires, at most as wide and at most 1024, as the page draws every distance as a vertex.
// Both become smaller together where the stations of one cell exceed the budget. Throws Error where
// these exceed it even at 256 pixels, naming the least budget.
WebPlan plan_export(const Room& room, const std::optional<RoomRequirements>& required,
                    const WebDemand& demand);

}  // namespace raywalk::render
