// Reads and stores the connection errors of a room (core/room/connection_errors.h).
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <vector>

#include "core/judge/validation/connect_error.h"

namespace raywalk {

// The stored measurements, one per generation; empty where the room has none. Throws Error as
// read_connection_errors does.
std::vector<ConnectError> read_connect_error(const std::filesystem::path& room);

// Adds a measurement; it replaces an earlier one of its generation. Throws Error where the room
// cannot be written.
void store_connect_error(const std::filesystem::path& room, const ConnectError& measurement);

// measure_connect_error(), with the result stored in the room. Throws Error before any work where
// the room cannot be written.
ConnectError measure_and_store_connect_error(const Room& room, Generation generation,
                                             const ConnectErrorOptions& options);

// The work of `raywalk-render connect-error`: measures each generation, stores it as soon as it is
// measured, and prints the table. Throws as measure_connect_error does,
// and Error before any work where the room cannot be written.
void write_connect_error(const Room& room, std::span<const Generation> generations,
                         const ConnectErrorOptions& options, std::ostream& table);

}  // namespace raywalk
