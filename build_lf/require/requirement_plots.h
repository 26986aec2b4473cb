// The plots of the report of `raywalk-build-lf require`, as <svg> elements.
#pragma once

#include <string>

#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Number of layers over the distance d_p from the line, up to the far side of the cell.
std::string layers_plot(const RoomRequirements& requirements);

// Ghost (distance between the two copies of a source, in pixels) over the station spacing, for
// different knowledge of the distances.
std::string ghost_plot(const RoomRequirements& requirements);

// PSNR of re-created stations over the step between the kept ones, and the PSNR of the tolerance.
std::string held_out_plot(const RoomRequirements& requirements);

// E_t over k for the room's distances. The room must have a cell.
std::string model_plot(const Room& room, const RoomRequirements& requirements);

// Measured E_connect over k, one curve per generation.
std::string measured_connection_plot(const Room& room);

}  // namespace raywalk::build_lf
