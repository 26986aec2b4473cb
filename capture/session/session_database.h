// session.db, opened for the one process that captures or for those that only look.
#pragma once

#include <filesystem>

#include "capture/plan/capture_plan.h"
#include "core/files/sqlite_connection.h"

namespace raywalk::capture {

// "<directory>/session.db".
std::filesystem::path session_database_path(const std::filesystem::path& directory);

// To write: WAL, every commit synced before it returns (synchronous FULL), foreign keys enforced. A
// file that is not there yet is made, still without tables. Throws Error: damaged, no session, of a
// newer version, read-only, on a file system without WAL.
SqliteConnection open_session_to_write(const std::filesystem::path& directory);

// To look, also while another process writes, and on disks that cannot be written. Throws Error as
// above; no session there; or entries that only the log holds on a disk that cannot be written.
SqliteConnection open_session_to_read(const std::filesystem::path& directory);

// Whether the tables are still to be made.
bool is_new_session(SqliteConnection* connection);

// Makes the tables, within the caller's transaction.
void create_session_tables(SqliteConnection* connection);

// The plan's lines and stations, written within the caller's transaction and read back.
void write_plan(SqliteConnection* connection, const CapturePlan& plan);
CapturePlan read_plan(SqliteConnection* connection);

}  // namespace raywalk::capture
