// Read-only access to a session, for status, verify, export and import. Everything is checked while
// it is read; a damaged value throws Error (core/session).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "capture/session/session.h"
#include "capture/session/session_database.h"
#include "core/files/json.h"
#include "core/files/sqlite_connection.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

// The plan that a session was created with.
CapturePlan plan_of(const SessionContents& contents);

// Works while a run writes, and on read-only disks; changes nothing.
class SessionReader {
 public:
  // Throws Error: no session, damaged, of a newer version.
  explicit SessionReader(std::filesystem::path directory);

  const std::filesystem::path& directory() const { return directory_; }
  SessionFacts facts();
  std::optional<WholePlan> part_of();  // none of a whole plan
  SessionContents contents();
  std::vector<JournalSample> journal(const std::string& line);  // in the order of recording
  // For queries that only one caller needs; docs/session.md documents the tables. `row` as for
  // SqliteStatement.
  SqliteStatement query(const std::string& sql, const std::string& row);
  SqliteConnection& database() { return database_; }

 private:
  CheckedJson json(const std::string& text, const std::string& column) const;

  std::filesystem::path directory_;
  SqliteConnection database_;
};

}  // namespace raywalk::capture
