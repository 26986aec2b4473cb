// The database of a capture session, checked before anything in it is believed.
// docs/session.md documents its tables.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/files/sqlite_connection.h"

namespace raywalk {

// "<directory>/session.db".
std::filesystem::path session_database_path(const std::filesystem::path& directory);

// Throws Error "<directory>/session.db: damaged: WHAT; ...".
[[noreturn]] void throw_damaged_session(const std::filesystem::path& directory,
                                        std::string_view what);

// Whether a database has no tables, as after an interrupted creation of a session.
bool is_empty_session(SqliteConnection* database);

// Throws Error: not a session, or of a newer version. Accepts a file without tables.
void require_session_format(SqliteConnection* database, const std::filesystem::path& directory);

// Throws Error if SQLite's integrity check finds damage or a row refers to a missing row. Reads the
// whole database.
void require_sound_session(SqliteConnection* database, const std::filesystem::path& directory);

// Opens for reading and checks format and soundness, also while another process writes, and on
// read-only disks. Throws Error: damaged, no session, of a newer version, or a read-only disk on
// which entries are only in the write-ahead log.
SqliteConnection open_session_to_read(const std::filesystem::path& directory);

}  // namespace raywalk
