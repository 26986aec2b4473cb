// A session survives a power loss at any moment of a station.
#include <gmock/gmock.h>

#include <random>

#include "capture/session/lossy_disk.h"
#include "capture/session/session_reader.h"
#include "capture/session/session_verify.h"
#include "capture/session/test_session.h"
#include "core/files/fingerprint.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using testing::IsEmpty;

// Captures until the power loss. Returns whether there was one.
bool capture_until_power_loss(TestCapture* capture) {
  try {
    capture->capture_missing(capture->open().get());
    return false;
  } catch (const PowerLoss&) {
    return true;
  }
}

std::size_t distinct_stations(SessionReader* reader) {
  std::set<std::string> stations;
  for (const FrameRecord& frame : reader->frames()) stations.insert(frame.station);
  return stations.size();
}

TEST(PowerLossTest, LeavesEveryCommittedFrameCompleteAtEveryOperation) {
  std::mt19937 random(7);
  int cuts = 0;
  for (int operation = 0;; ++operation) {
    const TestDirectory directory;
    LossyDisk disk;
    disk.power_lost_at = operation;
    TestCapture capture{.directory = directory / "session", .plan = short_plan(), .disk = &disk};
    if (!capture_until_power_loss(&capture)) break;
    ++cuts;
    std::filesystem::create_directories(capture.directory / "frames");
    disk.write_remains(&random);
    if (std::filesystem::exists(capture.directory / "session.db")) {
      SCOPED_TRACE(operation);
      capture.disk = &system_disk();
      const std::unique_ptr<Session> session = capture.open();
      SessionReader reader(capture.directory);
      EXPECT_THAT(verify_session(&reader).faults, IsEmpty());
      capture.capture_missing(session.get());
      EXPECT_EQ(reader.frames().size(), 3U);
      EXPECT_EQ(distinct_stations(&reader), 3U);
      EXPECT_THAT(verify_session(&reader).faults, IsEmpty());
    }
  }
  EXPECT_GE(cuts, 3 * 6);
}

// Shows that the test above can fail: it detects a row committed before its frame.
TEST(PowerLossTest, DetectsARowCommittedBeforeItsFrame) {
  const TestDirectory directory;
  LossyDisk disk;
  TestCapture capture{.directory = directory / "session", .plan = short_plan(), .disk = &disk};
  std::unique_ptr<Session> session = capture.open();
  const CaptureStation& station = capture.plan.lines[0].stations[0];
  const AttemptId attempt = session->begin_attempt(station.name, station.rail_mm);
  const StoredFrame early{
      .file = "frames/x0_000.jpg", .bytes = 5, .sha256 = sha256_hex("early"), .size = {64, 32}};
  session->complete_attempt(attempt, settled_at(50.0, 50.0), capture.shoot(station.name),
                            std::span(&early, 1), 1.0);
  SessionReader reader(capture.directory);
  EXPECT_EQ(verify_session(&reader).faults.size(), 1U);
}

}  // namespace
}  // namespace raywalk::capture
