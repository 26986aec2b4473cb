#include "core/session/session_file.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/session/session_schema.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_no_session(const fs::path& directory) {
  throw Error(
      fmt::format("{}: not a session of raywalk-capture; give the directory of "
                  "'run --session'",
                  directory.string()));
}

}  // namespace

fs::path session_database_path(const fs::path& directory) { return directory / "session.db"; }

void throw_damaged_session(const fs::path& directory, std::string_view what) {
  throw_damaged_database(session_database_path(directory), what);
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
}

SqliteConnection open_session_to_read(const fs::path& directory) {
  if (!fs::exists(session_database_path(directory))) throw_no_session(directory);
  SqliteConnection database(session_database_path(directory), SqliteAccess::kReadOnly);
  require_session_format(&database, directory);
  if (is_empty_session(&database)) throw_no_session(directory);
  require_sound_session(&database, directory);
  return database;
}

}  // namespace raywalk
