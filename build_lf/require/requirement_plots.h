// The plots of the report of `raywalk-build-lf require`, as <svg> elements.
#pragma once

#include <string>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Layers over the distance from the line, up to the cell's far side.
std::string layers_plot(const RoomRequirements& requirements);

// How far apart the copies of a source lie, in pixels, over the spacing of the stations, for what
// may be known of its distance.
std::string ghost_plot(const RoomRequirements& requirements);

// PSNR of stations made again over the step between those kept, and what the tolerance stands for.
std::string held_out_plot(const RoomRequirements& requirements);

// E_t over k for the room's distances. The room must have a cell.
std::string model_plot(const Room& room, const RoomRequirements& requirements);

// Measured E_connect over k, a curve per generation.
std::string measured_connection_plot(const Room& room);

}  // namespace raywalk::build_lf
