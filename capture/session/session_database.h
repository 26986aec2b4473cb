// Opening session.db for the process that captures, and writing its plan.
#pragma once

#include <filesystem>

#include "capture/plan/capture_plan.h"
#include "core/files/sqlite_connection.h"
#include "core/session/session_file.h"  // IWYU pragma: export

namespace raywalk::capture {

// Opens for writing: WAL, every commit synced before it returns (synchronous FULL), foreign keys
// enforced. Creates a missing file, without tables. Adds the copies of values (session_schema.h)
// that a session of an earlier program lacks. Throws Error: damaged, not a session, of a newer
// version, read-only, on a file system without WAL.
SqliteConnection open_session_to_write(const std::filesystem::path& directory);

// Creates the tables, within the caller's transaction.
void create_session_tables(SqliteConnection* connection);

// Writes the plan's lines and stations within the caller's transaction.
void write_plan(SqliteConnection* connection, const CapturePlan& plan);

}  // namespace raywalk::capture
