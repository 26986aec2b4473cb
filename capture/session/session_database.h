// Opening session.db for the process that captures or for reading.
#pragma once

#include <filesystem>

#include "capture/plan/capture_plan.h"
#include "core/files/sqlite_connection.h"

namespace raywalk::capture {

// "<directory>/session.db".
std::filesystem::path session_database_path(const std::filesystem::path& directory);

// Opens for writing: WAL, every commit synced before it returns (synchronous FULL), foreign keys
// enforced. Creates a missing file, without tables. Throws Error: damaged, not a session, of a
// newer version, read-only, on a file system without WAL.
SqliteConnection open_session_to_write(const std::filesystem::path& directory);

// Opens for reading, also while another process writes, and on read-only disks. Throws Error:
// damaged, no session, of a newer version, or a read-only disk on which entries are only in the
// write-ahead log.
SqliteConnection open_session_to_read(const std::filesystem::path& directory);

// Whether the tables do not exist yet.
bool is_new_session(SqliteConnection* connection);

// Creates the tables, within the caller's transaction.
void create_session_tables(SqliteConnection* connection);

// Writes the plan's lines and stations within the caller's transaction, and reads them back.
void write_plan(SqliteConnection* connection, const CapturePlan& plan);
CapturePlan read_plan(SqliteConnection* connection);

}  // namespace raywalk::capture
