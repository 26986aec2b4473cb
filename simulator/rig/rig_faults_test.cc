#include "simulator/rig/rig_faults.h"

#include <gtest/gtest.h>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

class RigFaultsTest : public ::testing::Test {
 protected:
  RigFaultsTest() {
    CaptureLine line{"x0", LineAxis::kX, 0.0, false, {}};
    for (int i = 0; i < 3; ++i) {
      line.stations.push_back({"x0_00" + std::to_string(i), {0.1 * i, 0.0}, 100.0 * i});
    }
    plan_.lines.push_back(line);
  }
  static SimulatedCameraSettings card_in(const std::filesystem::path& directory) {
    SimulatedCameraSettings settings;
    settings.card_directory = directory;
    return settings;
  }
  static ScheduledFault at_station(const std::string& kind, const std::string& station) {
    ScheduledFault scheduled;
    scheduled.fault.kind = kind;
    scheduled.at_station = station;
    return scheduled;
  }

  const TestDirectory directory_;
  ManualClock clock_;
  CapturePlan plan_;
  SimulatedDrive drive_{DriveSettings(), &clock_};
  LinkFaults link_{LinkFaultRates()};
  SimulatedCamera camera_{card_in(directory_ / "card"), clock_,
                          [](const ExposureNow&) { return std::string("picture"); }};
  RigFaults faults_{&drive_, &link_, &camera_};
};

TEST_F(RigFaultsTest, EveryKindCanBeInjected) {
  for (const std::string& kind : rig_fault_kinds()) {
    FaultRequest fault;
    fault.kind = kind;
    EXPECT_NO_THROW(faults_.inject(fault)) << kind;
  }
  EXPECT_TRUE(drive_.state().alarm);
  EXPECT_TRUE(drive_.state().at_low_limit);
  EXPECT_TRUE(drive_.state().at_high_limit);
  EXPECT_TRUE(link_.is_cut());
  EXPECT_TRUE(camera_.faults().occurs(CameraFault::kMissingPicture));
  faults_.clear();
  EXPECT_FALSE(drive_.state().alarm);
  EXPECT_FALSE(link_.is_cut());
  EXPECT_FALSE(camera_.faults().occurs(CameraFault::kTruncatedPicture));
}

TEST_F(RigFaultsTest, UnknownKindsAndStationsAreRefused) {
  FaultRequest fault;
  fault.kind = "stahl";
  EXPECT_THROW(faults_.inject(fault), UsageError);
  EXPECT_THROW(faults_.schedule(at_station("stahl", "x0_001"), plan_), UsageError);
  EXPECT_THROW(faults_.schedule(at_station("stall", "x7_001"), plan_), UsageError);
  ScheduledFault nothing_to_wait_for;
  nothing_to_wait_for.fault.kind = "stall";
  EXPECT_THROW(faults_.schedule(nothing_to_wait_for, plan_), UsageError);
}

TEST_F(RigFaultsTest, StationFaultOccursOnceAtItsMoveOnItsLine) {
  ScheduledFault alarm = at_station("alarm", "x0_001");
  alarm.fault.amount = 7.0;
  faults_.schedule(alarm, plan_);
  faults_.schedule(at_station("duplicated", "x0_001"), plan_);
  faults_.move_commanded("z0", 100.0);
  faults_.move_commanded("x0", 95.0);
  EXPECT_FALSE(drive_.state().alarm);
  faults_.move_commanded("x0", 100.005);
  EXPECT_EQ(drive_.state().alarm_code, 7);
  EXPECT_EQ(link_.next(), LinkFault::kDuplicated);
  drive_.reset_alarm();
  faults_.move_commanded("x0", 100.0);
  EXPECT_FALSE(drive_.state().alarm);
}

TEST_F(RigFaultsTest, ScheduledFaultsReachTheirDevices) {
  ScheduledFault late;
  late.fault.kind = "late";
  late.at_request = 2;
  faults_.schedule(late, plan_);
  EXPECT_EQ(link_.next(), LinkFault::kNone);
  EXPECT_EQ(link_.next(), LinkFault::kLate);
  ScheduledFault stall;
  stall.fault = {.kind = "stall", .for_ms = 1000.0, .after_ms = 500.0, .amount = 0, .requests = 1};
  stall.at_s = 1.0;
  faults_.schedule(stall, plan_);
  drive_.move_to(1000.0, {100.0, 1000.0, 1000.0});
  clock_.sleep(duration_from_ms(1500.0));
  const double blocked_mm = drive_.state().feedback_mm;
  clock_.sleep(duration_from_ms(900.0));
  EXPECT_EQ(drive_.state().feedback_mm, blocked_mm);
  clock_.sleep(duration_from_ms(900.0));
  EXPECT_GT(drive_.state().feedback_mm, blocked_mm);
  ScheduledFault missing;
  missing.fault.kind = "missing-picture";
  missing.at_picture = 1;
  faults_.schedule(missing, plan_);
  const std::string id = camera_.take_picture();
  clock_.sleep(std::chrono::seconds(10));
  EXPECT_TRUE(camera_.progress_of(id).done);
  EXPECT_TRUE(camera_.progress_of(id).camera_name.empty());
}

}  // namespace
}  // namespace raywalk::capture
