#include "capture/session/session_database.h"

#include <gmock/gmock.h>

#include <fstream>

#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/session/session_schema.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SessionDatabaseTest : public testing::Test {
 protected:
  void make_session() {
    SqliteConnection connection = open_session_to_write(directory_.path());
    create_session(&connection, {}, test_plan(true));
  }
  std::filesystem::path file() const { return session_database_path(directory_.path()); }
  std::string error_of_reading() {
    return error_of([&] { open_session_to_read(directory_.path()); });
  }
  std::string error_of_writing() {
    return error_of([&] { open_session_to_write(directory_.path()); });
  }
  void expect_both(const testing::Matcher<std::string>& message) {
    EXPECT_THAT(error_of_reading(), message);
    EXPECT_THAT(error_of_writing(), message);
  }

  TestDirectory directory_;
};

TEST_F(SessionDatabaseTest, SyncsEveryCommitAndEnforcesForeignKeys) {
  make_session();
  SqliteConnection connection = open_session_to_write(directory_.path());
  EXPECT_EQ(connection.text("PRAGMA journal_mode"), "wal");
  EXPECT_EQ(connection.integer("PRAGMA synchronous"), 2);  // FULL
  EXPECT_THROW(connection.execute("INSERT INTO station VALUES (999, 999, 0, 'lost', 0, 0, 0)"),
               Error);
}

TEST_F(SessionDatabaseTest, AnUncommittedTransactionNeverHappened) {
  make_session();
  SqliteConnection connection = open_session_to_write(directory_.path());
  {
    const SqliteTransaction transaction(&connection);
    connection.execute("INSERT INTO event VALUES (1, 0, 'kind', 'text')");
  }
  EXPECT_EQ(connection.integer("SELECT count(*) FROM event"), 0);
}

TEST_F(SessionDatabaseTest, SaysThatTheDiskIsFull) {
  make_session();
  SqliteConnection connection = open_session_to_write(directory_.path());
  connection.execute("PRAGMA max_page_count = 1");
  SqliteStatement add(&connection, "INSERT INTO event (at_utc_us, kind, text) VALUES (0, '', ?1)");
  EXPECT_THAT(error_of([&] { add.bind(std::string(1 << 20, 'x')).run(); }),
              AllOf(HasSubstr("session.db"), HasSubstr("disk is full")));
  connection.execute("PRAGMA max_page_count = 1000000");
  EXPECT_NO_THROW(add.bind("fits").run());
}

TEST_F(SessionDatabaseTest, SaysThatItCannotBeWritten) {
  make_session();
  SqliteConnection connection = open_session_to_read(directory_.path());
  EXPECT_THAT(error_of([&] { connection.execute("DELETE FROM station"); }),
              AllOf(HasSubstr("session.db"), HasSubstr("cannot be written")));
}

TEST_F(SessionDatabaseTest, RefusesFilesThatAreNotADatabase) {
  std::ofstream(file()) << std::string(5000, 'x');
  expect_both(AllOf(HasSubstr("session.db"), HasSubstr("not an SQLite database")));
}

TEST_F(SessionDatabaseTest, RefusesAnotherDatabase) {
  SqliteConnection(file(), SqliteAccess::kReadWrite).execute("CREATE TABLE mine (a)");
  expect_both(HasSubstr("not a session of raywalk-capture"));
}

TEST_F(SessionDatabaseTest, RefusesANewerFormat) {
  make_session();
  SqliteConnection(file(), SqliteAccess::kReadWrite)
      .execute(fmt::format("PRAGMA user_version = {}", kSessionFormatVersion + 1));
  expect_both(AllOf(HasSubstr("newer"), HasSubstr("format 2, this program reads up to 1")));
}

TEST_F(SessionDatabaseTest, FindsDamageBeforeAnythingIsCaptured) {
  make_session();
  {
    // Everything after the first page, which holds the file's header.
    std::fstream damaged(file(), std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(4096);
    damaged << std::string(std::filesystem::file_size(file()) - 4096, '\x5a');
  }
  EXPECT_THAT(error_of_writing(), AllOf(HasSubstr("session.db"), HasSubstr("damaged"),
                                        HasSubstr("frames are untouched"), Not(HasSubstr("\n"))));
}

TEST_F(SessionDatabaseTest, FindsATruncatedDatabase) {
  make_session();
  std::filesystem::resize_file(file(), 3 * 4096);
  EXPECT_THAT(error_of_writing(), HasSubstr("damaged"));
}

TEST_F(SessionDatabaseTest, NamesTheDirectoryWithoutASession) {
  EXPECT_THAT(error_of_reading(), HasSubstr("not a session of raywalk-capture"));
  std::ofstream(file()).close();
  EXPECT_THAT(error_of_reading(), HasSubstr("not a session of raywalk-capture"));
}

TEST_F(SessionDatabaseTest, IsReadWhileAnotherConnectionWrites) {
  make_session();
  SqliteConnection writer = open_session_to_write(directory_.path());
  SqliteConnection reader = open_session_to_read(directory_.path());
  const SqliteTransaction transaction(&writer);
  writer.execute("INSERT INTO event VALUES (1, 0, 'kind', 'text')");
  EXPECT_EQ(reader.integer("SELECT count(*) FROM event"), 0);
}

// A dangling link in place of the log's index, which SQLite does not follow, has the effect of a
// read-only disk for every user.
TEST_F(SessionDatabaseTest, IsReadOnAReadOnlyDisk) {
  make_session();
  std::filesystem::create_symlink("nowhere", directory_ / "session.db-shm");
  SqliteConnection reader = open_session_to_read(directory_.path());
  EXPECT_EQ(reader.integer("SELECT count(*) FROM line"), 5);
}

TEST_F(SessionDatabaseTest, RefusesToIgnoreEntriesInTheLog) {
  make_session();
  std::filesystem::create_symlink("nowhere", directory_ / "session.db-shm");
  std::ofstream(directory_ / "session.db-wal") << "entries";
  EXPECT_THAT(error_of_reading(),
              AllOf(HasSubstr("session.db-wal"), HasSubstr("copy the directory")));
}

TEST_F(SessionDatabaseTest, ANameMayContainReservedCharactersOfUris) {
  const std::filesystem::path odd = directory_ / "100%?#";
  std::filesystem::create_directory(odd);
  SqliteConnection(session_database_path(odd), SqliteAccess::kReadWrite)
      .execute("PRAGMA journal_mode = WAL; CREATE TABLE mine (a)");
  std::filesystem::create_symlink("nowhere", odd / "session.db-shm");
  SqliteConnection reader(session_database_path(odd), SqliteAccess::kReadOnly);
  EXPECT_EQ(reader.integer("SELECT count(*) FROM sqlite_master"), 1);
}

}  // namespace
}  // namespace raywalk::capture
