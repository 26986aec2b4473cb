#include "capture/session/session_verify.h"

#include <gmock/gmock.h>

#include <fstream>

#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

class SessionVerifyTest : public testing::Test {
 protected:
  SessionVerifyTest() { capture_.capture_missing(capture_.open().get()); }

  SessionVerification verify() {
    SessionReader reader(capture_.directory);
    return verify_session(&reader);
  }
  fs::path frame() const { return capture_.directory / "frames/x0_001.jpg"; }

  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session", .plan = short_plan()};
};

TEST_F(SessionVerifyTest, FindsNoFaultInACompleteSession) {
  const SessionVerification verification = verify();
  EXPECT_TRUE(verification.is_whole());
  EXPECT_EQ(verification.frames, 3);
  EXPECT_EQ(verification.bytes,
            3 * static_cast<std::int64_t>(test_picture("x0_000 0").bytes.size()));
  EXPECT_THAT(verification.leftover, IsEmpty());
}

TEST_F(SessionVerifyTest, FindsAMissingFrame) {
  fs::remove(frame());
  EXPECT_THAT(verify().faults, ElementsAre(AllOf(HasSubstr("x0_001.jpg"), HasSubstr("No such"))));
}

TEST_F(SessionVerifyTest, FindsATruncatedFrame) {
  fs::resize_file(frame(), 10);
  EXPECT_THAT(verify().faults, ElementsAre(AllOf(HasSubstr("x0_001.jpg"), HasSubstr("10 bytes"))));
}

TEST_F(SessionVerifyTest, FindsOneChangedBit) {
  std::fstream(frame(), std::ios::in | std::ios::out | std::ios::binary).seekp(500).put('/');
  EXPECT_THAT(verify().faults, ElementsAre(AllOf(HasSubstr("x0_001.jpg"), HasSubstr("SHA-256"))));
}

TEST_F(SessionVerifyTest, FindsADirectoryInPlaceOfAFrame) {
  fs::remove(frame());
  fs::create_directory(frame());
  EXPECT_EQ(verify().faults.size(), 1U);
}

TEST_F(SessionVerifyTest, ListsFilesOfNoStationWithoutAFault) {
  std::ofstream(capture_.directory / "frames/x0_001_a2.jpg") << "left";
  const SessionVerification verification = verify();
  EXPECT_TRUE(verification.is_whole());
  EXPECT_THAT(verification.leftover, ElementsAre("frames/x0_001_a2.jpg"));
  EXPECT_THAT(verification_text(verification), HasSubstr("frames/x0_001_a2.jpg: belongs to no"));
}

TEST_F(SessionVerifyTest, FindsACapturedStationWithoutAFrame) {
  open_session_to_write(capture_.directory).execute("DELETE FROM frame WHERE file LIKE '%x0_002%'");
  EXPECT_THAT(verify().faults, ElementsAre(HasSubstr("1 captured stations have no frame")));
}

TEST_F(SessionVerifyTest, FindsRowsThatReferToMissingRows) {
  SqliteConnection(session_database_path(capture_.directory), SqliteAccess::kReadWrite)
      .execute("DELETE FROM station WHERE name = 'x0_002'");
  EXPECT_THAT(verify().faults, ElementsAre(HasSubstr("rows refer to missing rows")));
}

TEST_F(SessionVerifyTest, EndsInOneLineThatNamesTheFirstFault) {
  SessionReader reader(capture_.directory);
  EXPECT_NO_THROW(require_whole(verify(), reader));
  fs::remove(frame());
  fs::remove(capture_.directory / "frames/x0_002.jpg");
  EXPECT_THAT(error_of([&] { require_whole(verify(), reader); }),
              AllOf(HasSubstr(capture_.directory.string()), HasSubstr("x0_001.jpg"),
                    HasSubstr("2 faults")));
}

}  // namespace
}  // namespace raywalk::capture
