// The measured connection errors that a room keeps, in ROOM/connect-error.json: one measurement per
// generation, each with the settings it was made with.
//
//   {"format_version": 1,
//    "measurements": [{"generation", "viewpoints", "overlap_deg",
//                      "rows": [{"connection", "k_deg", "e_connect", "e_connect_common",
//                                "coverage"}]}]}
//
// An error that could not be measured is null. Measure again after distances were replaced.
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <vector>

#include "render/validation/connect_error.h"

namespace raywalk {

std::filesystem::path connect_error_path(const std::filesystem::path& room);

// Empty where the room has none. Throws Error naming the file where it is damaged or of a newer
// format version, and how to make it anew.
std::vector<ConnectError> read_connect_error(const std::filesystem::path& room);

// Adds a measurement; it replaces an earlier one of its generation. A file that cannot be read is
// replaced with a warning. Throws Error where the room cannot be written.
void store_connect_error(const std::filesystem::path& room, const ConnectError& measurement);

// The work of `raywalk-render connect-error`: measures each generation, stores it as soon as it is
// measured, and prints the table. Throws as measure_connect_error does, and Error before any work
// where the room cannot be written.
void write_connect_error(const Room& room, std::span<const Generation> generations,
                         const ConnectErrorOptions& options, std::ostream& table);

}  // namespace raywalk
