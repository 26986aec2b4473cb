#include "capture/session/merge_sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "capture/plan/line_selection.h"
#include "capture/session/session_frames.h"
#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

class MergeSessionsTest : public ::testing::Test {
 protected:
  // Captures lines of the test plan, or of `plan`, in a session; `hour` orders the sessions.
  void capture(const std::string& name, const std::vector<std::string>& lines, int hour,
               int stations = 1000, const CapturePlan& plan = test_plan(true)) {
    TestCapture rig{.directory = root_ / name};
    rig.plan = select_lines(plan, rig.config.camera, lines);
    rig.clock.sleep(duration_from_ms(3.6e6 * hour));
    rig.off_mm = 0.01 * hour;
    const auto session = rig.open();
    session->record_event("run-started", "the rig of " + name);
    rig.capture_missing(session.get(), stations);
  }
  MergeOptions options(const std::vector<std::string>& names) const {
    MergeOptions options{.sessions = {}, .out = root_ / "hall"};
    for (const std::string& name : names) options.sessions.push_back(root_ / name);
    return options;
  }
  std::string merge(const MergeOptions& options) { return merge_sessions(options, &clock_); }
  std::string refusal(const MergeOptions& options) {
    const std::string message = error_of([&] { merge(options); });
    EXPECT_FALSE(fs::exists(options.out));
    return message;
  }
  std::string events() {
    SessionReader session(root_ / "hall");
    std::string text;
    SqliteStatement row =
        session.query("SELECT kind || ' ' || text FROM event ORDER BY id", "event");
    while (row.step()) text += row.text(0) + "\n";
    return text;
  }

  TestDirectory root_;
  ManualClock clock_{};
};

TEST_F(MergeSessionsTest, SessionsOfSomeLinesBecomeTheSessionOfThePlan) {
  capture("monday", {"x0", "z1"}, 1);
  capture("tuesday", {"x1", "z0", "v0"}, 2);
  EXPECT_THAT(merge(options({"tuesday", "monday"})),
              HasSubstr("hall: 15 frames and 5 lines of 2 sessions"));
  SessionReader merged(root_ / "hall");
  EXPECT_TRUE(verify_session(&merged).is_whole());
  std::vector<std::string> stations;
  const SessionContents contents = merged.contents();
  for (const SessionStation& station : contents.stations) {
    EXPECT_TRUE(station.shot) << station.name;
    stations.push_back(station.name);
  }
  EXPECT_EQ(stations.front(), "x0_000");
  EXPECT_EQ(stations.back(), "v0_002");
  // As one run would have left it: complete for the same configuration, and in the order of time.
  TestCapture rig{.directory = root_ / "hall", .plan = test_plan(true)};
  rig.clock.sleep(duration_from_ms(3.6e6 * 10));
  EXPECT_EQ(rig.open()->exposure(), "");
  SqliteStatement row = merged.query(
      "SELECT count(*), sum(begun_utc_us < (SELECT begun_utc_us FROM attempt AS before WHERE "
      "before.id = attempt.id - 1)), min(measured_mm - commanded_mm), max(measured_mm - "
      "commanded_mm) FROM attempt",
      "attempts");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(row.integer(0, 0, 100), 15);
  EXPECT_EQ(row.integer(1, 0, 100), 0);
  EXPECT_NEAR(row.real(2, 0.0, 1.0), 0.01, 1e-9);
  EXPECT_NEAR(row.real(3, 0.0, 1.0), 0.02, 1e-9);
  EXPECT_THAT(events(),
              AllOf(HasSubstr("run-started monday: the rig of monday\n"
                              "run-started tuesday: the rig of tuesday\n"),
                    HasSubstr("merged x0: 3 stations of " + (root_ / "monday").string())));
  EXPECT_EQ(fs::hard_link_count(root_ / "hall" / "frames" / "x0_000.jpg"), 2u);
}

TEST_F(MergeSessionsTest, ALineCapturedAgainReplacesTheOlderOneIfAsked) {
  capture("whole", {}, 1);
  capture("again", {"z0"}, 2);
  EXPECT_THAT(refusal(options({"again", "whole"})),
              AllOf(HasSubstr("line z0 is captured in " + (root_ / "whole").string()),
                    HasSubstr("later, in " + (root_ / "again").string()), HasSubstr("--replace")));
  MergeOptions replacing = options({"again", "whole"});
  replacing.replace = true;
  EXPECT_THAT(merge(replacing), HasSubstr("z0 of again replaces that of whole"));
  const auto is_of = [&](const std::string& frame, const std::string& session) {
    return fs::equivalent(root_ / "hall" / "frames" / frame, root_ / session / "frames" / frame);
  };
  EXPECT_TRUE(is_of("z0_001.jpg", "again"));
  EXPECT_TRUE(is_of("z1_001.jpg", "whole"));
  EXPECT_THAT(events(), HasSubstr("in place of that of " + (root_ / "whole").string()));
}

TEST_F(MergeSessionsTest, MissingAndUnfinishedLinesAreNamed) {
  capture("monday", {"x0", "z0"}, 1, 4);  // one station of z0
  capture("tuesday", {"z1"}, 2);
  EXPECT_THAT(refusal(options({"monday", "tuesday"})),
              AllOf(HasSubstr("2 lines of the plan: x1, v0"),
                    HasSubstr("not finished: z0 (1 of 3)"), HasSubstr("--partial")));
  MergeOptions partial = options({"monday", "tuesday"});
  partial.partial = true;
  EXPECT_THAT(merge(partial), HasSubstr("missing: x1, v0"));
  // What is missing is merged into it later.
  capture("wednesday", {"x1", "v0", "z0"}, 3);
  MergeOptions rest = options({"hall", "wednesday"});
  rest.replace = true;
  rest.out = root_ / "complete";
  EXPECT_THAT(merge(rest), HasSubstr("15 frames and 5 lines"));
}

TEST_F(MergeSessionsTest, OtherPlansCamerasAndPlacesAreRefused) {
  capture("monday", {"x0"}, 1);
  CapturePlan other = test_plan(true);
  other.lines[1].stations[0].position_m.x_m += 0.01;
  capture("other", {"x1"}, 2, 1000, other);
  EXPECT_THAT(refusal(options({"monday", "other"})), HasSubstr("different plans"));
  TestCapture rig{.directory = root_ / "card"};
  rig.config.camera.kind = CameraKind::kGpio;
  rig.plan = select_lines(test_plan(true), rig.config.camera, {"x1"});
  rig.open();
  EXPECT_THAT(refusal(options({"monday", "card"})), HasSubstr("the camera is osc and gpio"));
  EXPECT_THAT(refusal(options({"monday", "monday"})), HasSubstr("given twice"));
  MergeOptions onto = options({"monday"});
  onto.out = root_ / "monday";
  EXPECT_THAT(error_of([&] { merge(onto); }), HasSubstr("exists"));
}

TEST_F(MergeSessionsTest, AStoppedMergeGoesOnAndForeignFilesStay) {
  capture("monday", {}, 1);
  const fs::path partial = root_ / "hall.partial";
  fs::create_directories(partial / "frames");
  write_file_atomically(partial / "frames" / "x0_000.jpg", "half of another merge");
  write_file_atomically(partial / "frames" / "y9_000.jpg", "left over");
  write_file_atomically(partial / "session.db", "torn");
  write_file_atomically(partial / "notes.txt", "mine");
  EXPECT_THAT(refusal(options({"monday"})), HasSubstr("notes.txt"));
  fs::remove(partial / "notes.txt");
  merge(options({"monday"}));
  SessionReader merged(root_ / "hall");
  EXPECT_TRUE(verify_session(&merged).is_whole());
  EXPECT_FALSE(fs::exists(root_ / "hall" / "frames" / "y9_000.jpg"));
  EXPECT_FALSE(fs::exists(partial));
}

}  // namespace
}  // namespace raywalk::capture
