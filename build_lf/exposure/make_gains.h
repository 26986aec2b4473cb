// Solves for a room's gains and stores them: `raywalk-build-lf gains`, and the end of `depth`.
#pragma once

#include <filesystem>
#include <string>

#include "core/room/gain_fields.h"

namespace raywalk::build_lf {

struct GainsSummary {
  int stations = 0;   // of the room
  int corrected = 0;  // whose gains are not 1
  int local = 0;      // of these, whose gains vary over the picture
  // Over the sphere of all stations, natural logarithms: root mean square, and the largest factor
  // away from 1 (as a factor above or below 1).
  double spread = 0.0;
  double largest = 1.0;
};

GainsSummary summary_of(const GainFields& fields);

// The summary as a sentence without a full stop.
std::string text_of(const GainsSummary& summary);

// Solves for the gains with the distances in use and replaces those of the room. Throws Error as
// Room::open does for all but the gains, if the room has no distances, and as replace_gains.
GainsSummary make_gains(const std::filesystem::path& room);

// Makes these the gains of the room: ROOM/gains.h5, recorded in the manifest; no file if all are 1.
// The room is valid at each moment: the manifest first records the old and the new file, then the
// file is renamed.
// Removes measurements made with others. Throws Error if it cannot be written or another process is
// changing the room.
void replace_gains(const std::filesystem::path& room, const GainFields& fields);

// Removes the gains; whether there were any.
bool remove_gains(const std::filesystem::path& room);

}  // namespace raywalk::build_lf
