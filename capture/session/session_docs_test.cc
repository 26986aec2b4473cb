// Checks docs/session.md against a real session: every column is explained, every example runs.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"

namespace raywalk::capture {
namespace {

using testing::ContainsRegex;
using testing::SizeIs;

class SessionDocsTest : public SessionCase {
 protected:
  SessionDocsTest() : SessionCase(test_plan()) {
    const std::unique_ptr<Session> session = capture_.open();
    session->record_event("run-started", "a slider, a camera");
    session->record_event("merged", "x0: 3 stations of monday");
    session->fail_attempt(session->begin_attempt("x0_000", 50.0), "stall", "it stood still");
    capture_.capture_missing(session.get());
    const JournalSample samples[] = {{capture_.clock.wall_now(), 50.0},
                                     {capture_.clock.wall_now() + std::chrono::seconds(1), 70.0}};
    session->record_journal("x0", samples);
  }

  std::vector<std::string> queries() const {
    std::vector<std::string> queries;
    const std::regex block("```sql\n([^`]*)```");
    for (std::sregex_iterator i(docs_.begin(), docs_.end(), block), end; i != end; ++i) {
      queries.push_back((*i)[1]);
    }
    return queries;
  }

  // Table -> the names in backquotes in the first cell of its rows.
  std::map<std::string, std::set<std::string>> documented_columns() const {
    std::map<std::string, std::set<std::string>> columns;
    std::string table;
    std::istringstream lines(docs_);
    const std::regex word("`([a-z0-9_]+)`");
    for (std::string line; std::getline(lines, line);) {
      std::smatch heading;
      if (std::regex_match(line, heading, std::regex("### `([a-z_]+)`"))) table = heading[1];
      if (line.starts_with("## ")) table.clear();
      if (table.empty() || !line.starts_with("| `")) continue;
      const std::string cell = line.substr(0, line.find(" | "));
      for (std::sregex_iterator i(cell.begin(), cell.end(), word), end; i != end; ++i) {
        columns[table].insert((*i)[1]);
      }
    }
    return columns;
  }

  std::string docs_ = read_file(RAYWALK_DOCS "/session.md");
};

TEST_F(SessionDocsTest, EveryExampleReturnsRows) {
  SqliteConnection connection = open_session_to_read(capture_.directory);
  ASSERT_THAT(queries(), SizeIs(9));
  for (const std::string& query : queries()) {
    SqliteStatement statement(&connection, query);
    EXPECT_TRUE(statement.step()) << query;
    EXPECT_FALSE(statement.is_null(0)) << query;
  }
}

TEST_F(SessionDocsTest, ExplainsExactlyTheExistingColumns) {
  SqliteConnection connection = open_session_to_read(capture_.directory);
  SqliteStatement row(&connection,
                      "SELECT sqlite_master.name, columns.name FROM sqlite_master, "
                      "pragma_table_info(sqlite_master.name) AS columns "
                      "WHERE sqlite_master.type IN ('table', 'view')");
  std::map<std::string, std::set<std::string>> columns;
  while (row.step()) columns[row.text(0)].insert(row.text(1));
  EXPECT_EQ(documented_columns(), columns);
}

TEST_F(SessionDocsTest, ExplainsEveryKeyOfTheStatus) {
  SessionReader reader(capture_.directory);
  const nlohmann::json status = session_status(&reader);
  std::vector<std::string> keys;
  for (const auto& [key, value] : status.items()) keys.push_back(key);
  for (const auto& [key, value] : status["lines"][0].items()) keys.push_back(key);
  for (const auto& [key, value] : status["times"].items()) keys.push_back(key);
  const std::string section = docs_.substr(docs_.find("## `status --json`"));
  for (const std::string& key : keys) {
    EXPECT_THAT(section, ContainsRegex("`" + key + "(\\[\\])?`"));
  }
}

}  // namespace
}  // namespace raywalk::capture
