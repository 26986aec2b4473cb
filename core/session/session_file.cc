#include "core/session/session_file.h"

#include <fmt/format.h>

#include <map>
#include <string>

#include "core/base/error.h"
#include "core/session/session_schema.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// The definitions of tables, indexes and views by name.
std::map<std::string, std::string> definitions_of(SqliteConnection* database) {
  SqliteStatement row(database, "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL");
  std::map<std::string, std::string> definitions;
  while (row.step()) definitions[row.text(0)] = row.text(1);
  return definitions;
}

std::map<std::string, std::string> definitions_made_by(const char* schema) {
  SqliteConnection memory(":memory:", SqliteAccess::kReadWrite);
  memory.execute(schema);
  return definitions_of(&memory);
}

// A damaged definition may still be valid SQL that selects other rows.
void require_tables(SqliteConnection* database, const fs::path& directory) {
  static const auto kExpected = definitions_made_by(kSessionSchema);
  const auto there = definitions_of(database);
  for (const auto& [name, sql] : kExpected) {
    const auto found = there.find(name);
    if (found == there.end()) {
      throw_damaged_session(directory, fmt::format("it has no '{}'", name));
    }
    if (found->second != sql) {
      throw_damaged_session(directory, fmt::format("the definition of '{}' was changed", name));
    }
  }
}

[[noreturn]] void throw_no_session(const fs::path& directory) {
  throw Error(
      fmt::format("{}: not a session of raywalk-capture; give the directory of "
                  "'run --session'",
                  directory.string()));
}

}  // namespace

fs::path session_database_path(const fs::path& directory) { return directory / "session.db"; }

void throw_damaged_session(const fs::path& directory, std::string_view what) {
  throw Error(one_line(
      fmt::format("{}: damaged: {}; the frames are untouched: restore this file from a copy, or "
                  "recover its rows with 'sqlite3 session.db .recover'",
                  session_database_path(directory).string(), what)));
}

bool is_empty_session(SqliteConnection* database) {
  return database->integer("SELECT count(*) FROM sqlite_master") == 0;
}

void require_session_format(SqliteConnection* database, const fs::path& directory) {
  if (is_empty_session(database)) return;
  if (database->integer("PRAGMA application_id") != kSessionApplicationId) {
    throw Error(fmt::format("{}: not a session of raywalk-capture; give another directory",
                            session_database_path(directory).string()));
  }
  const std::int64_t version = database->integer("PRAGMA user_version");
  if (version > kSessionFormatVersion) {
    throw Error(fmt::format(
        "{}: written by a newer raywalk-capture (format {}, this program reads up to {}); use the "
        "programs of that version",
        session_database_path(directory).string(), version, kSessionFormatVersion));
  }
  if (version < 1) {
    throw_damaged_session(directory, fmt::format("its format is {}, not 1 or more", version));
  }
}

void require_sound_session(SqliteConnection* database, const fs::path& directory) {
  const SqliteTransaction snapshot(database, SqliteTransaction::Kind::kRead);
  const std::string found = database->text("PRAGMA integrity_check(1)");
  if (found != "ok") throw_damaged_session(directory, found);
  const std::int64_t dangling =
      database->integer("SELECT count(*) FROM pragma_foreign_key_check()");
  if (dangling > 0) {
    throw_damaged_session(directory, fmt::format("{} rows refer to missing rows", dangling));
  }
  require_tables(database, directory);
}

SqliteConnection open_session_to_read(const fs::path& directory) {
  if (!fs::exists(session_database_path(directory))) throw_no_session(directory);
  SqliteConnection database = open_sqlite_read_only(session_database_path(directory));
  require_session_format(&database, directory);
  if (is_empty_session(&database)) throw_no_session(directory);
  require_sound_session(&database, directory);
  return database;
}

}  // namespace raywalk
