#include "capture/session/session_frames.h"

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
  std::vector<std::string> faults() {
    std::vector<std::string> texts;
    for (const FrameFault& fault : verify().faults) texts.push_back(fault.text);
    return texts;
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

TEST_F(SessionVerifyTest, FindsADirectoryInPlaceOfAFrame) {
  fs::remove(frame());
  fs::create_directory(frame());
  EXPECT_THAT(faults(), ElementsAre(HasSubstr("not a regular file")));
}

TEST_F(SessionVerifyTest, ListsFilesOfNoStationWithoutAFault) {
  std::ofstream(capture_.directory / "frames/x0_001_a2.jpg") << "left";
  const SessionVerification verification = verify();
  EXPECT_TRUE(verification.is_whole());
  EXPECT_THAT(verification.leftover, ElementsAre("frames/x0_001_a2.jpg"));
  EXPECT_THAT(verification_text(verification), HasSubstr("frames/x0_001_a2.jpg: belongs to no"));
}

TEST_F(SessionVerifyTest, FindsRowsThatReferToMissingRows) {
  SqliteConnection(session_database_path(capture_.directory), SqliteAccess::kReadWrite)
      .execute("DELETE FROM station WHERE name = 'x0_002'");
  EXPECT_THAT(error_of([&] { verify(); }), HasSubstr("rows refer to missing rows"));
}

TEST_F(SessionVerifyTest, EndsInOneLineThatNamesTheFirstFault) {
  EXPECT_NO_THROW(require_no_faults(verify().faults, capture_.directory));
  fs::remove(frame());
  fs::remove(capture_.directory / "frames/x0_002.jpg");
  EXPECT_THAT(error_of([&] { require_no_faults(verify().faults, capture_.directory); }),
              AllOf(HasSubstr(capture_.directory.string()), HasSubstr("x0_001.jpg"),
                    HasSubstr("1 more"), HasSubstr("--give-up")));
}

TEST_F(SessionVerifyTest, StationsOfLostFramesCanBeCapturedAgain) {
  fs::remove(frame());
  std::ofstream(capture_.directory / "frames/x0_002.jpg") << "other";
  EXPECT_THAT(give_up_lost_stations(verify(), capture_.directory, &capture_.clock),
              HasSubstr("2 stations given up"));
  EXPECT_TRUE(verify().is_whole());
  EXPECT_EQ(verify().frames, 1);
  const std::unique_ptr<Session> session = capture_.open();
  EXPECT_TRUE(session->is_captured("x0_000"));
  EXPECT_FALSE(session->is_captured("x0_001"));
  capture_.capture_missing(session.get());
  EXPECT_TRUE(verify().is_whole());
  EXPECT_EQ(verify().frames, 3);
  EXPECT_THAT(verify().leftover, ElementsAre("frames/x0_002.jpg"));
}

TEST_F(SessionVerifyTest, LostPicturesOfACardCanBeImportedAgain) {
  capture_.directory = directory_ / "card";
  capture_.config.camera.kind = CameraKind::kGpio;
  const std::unique_ptr<Session> session = capture_.open();
  capture_.capture_missing(session.get());
  const SessionContents exposed = session->contents();
  const AttemptId attempt{exposed.stations[0].shot->attempt, "x0_000", 1};
  const StoredFrame frame = session->store_frame(attempt, 0, test_picture("card"));
  session->add_pictures(attempt, {&frame, 1});
  EXPECT_FALSE(session->contents().stations[0].shot->on_card);
  session->give_up_frames("x0_000");
  EXPECT_TRUE(session->contents().stations[0].shot->on_card);
  EXPECT_TRUE(session->contents().frames.empty());
}

}  // namespace
}  // namespace raywalk::capture
