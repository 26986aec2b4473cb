// raywalk-capture with a rig that fails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/end_to_end/capture_command.h"

namespace raywalk {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

struct FaultCase {
  const char* name;
  json fault;
  std::vector<const char*> says;  // patterns of the error line
};

class CaptureFaultTest : public CaptureCommandTest,
                         public ::testing::WithParamInterface<FaultCase> {};

TEST_P(CaptureFaultTest, PausesWithAnErrorLineAndResumesAfterRepair) {
  files_.speed_mm_s = 2000.0;
  files_.more_capture = "  shots: 2\n";
  start_rig();
  auto process = run_in_background();
  const auto moves = rig_state()["moves"].get<int>();
  while (rig_state()["moves"].get<int>() < moves + 3) {
    ASSERT_FALSE(process->has_ended()) << run_log();
  }
  rig_fault(GetParam().fault);
  EXPECT_EQ(process->wait(), 3) << run_log();
  const std::string log = run_log();
  const std::string line = log.substr(log.rfind("raywalk-capture: error:"));
  EXPECT_THAT(line, AllOf(HasSubstr("x0"), HasSubstr(";"), HasSubstr("the same command resumes")));
  for (const char* text : GetParam().says) EXPECT_THAT(line, ContainsRegex(text));
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
  mend_rig();
  // A cut link and a camera that was down recover by themselves; a blocked drive must be homed.
  for (int i = 0; i < 1000 && !is_rig_reachable(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const CommandResult resumed = run();
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  expect_finished_session();
}

INSTANTIATE_TEST_SUITE_P(
    Faults, CaptureFaultTest,
    // The fault may occur before or after the carriage starts to move.
    ::testing::Values(
        FaultCase{"Stall", {{"kind", "stall"}}, {"does not move|stalled"}},
        // A drive may also end the move at the switch by itself.
        FaultCase{
            "LimitSwitch", {{"kind", "high-limit"}}, {"does not move|stalled|off its target"}},
        FaultCase{"Cut", {{"kind", "cut"}}, {"stop"}},
        FaultCase{"FeedbackJump", {{"kind", "feedback-jump"}, {"amount", 30.0}}, {"mm"}},
        FaultCase{"Busy", {{"kind", "busy"}}, {"camera", "busy"}},
        FaultCase{"CardFull", {{"kind", "card-full"}, {"for_ms", 60000}}, {"card"}},
        FaultCase{"WebPage", {{"kind", "web-page"}, {"for_ms", 60000}}, {"web page"}},
        FaultCase{"CameraDown", {{"kind", "down"}, {"for_ms", 3000}}, {"127.0.0.1"}}),
    [](const ::testing::TestParamInfo<FaultCase>& param) { return param.param.name; });

TEST_F(CaptureCommandTest, AnAlarmIsNamedAndMustBeClearedManually) {
  files_.speed_mm_s = 2000.0;
  start_rig();
  auto process = run_in_background();
  while (rig_state()["moves"].get<int>() < 3) ASSERT_FALSE(process->has_ended()) << run_log();
  rig_fault({{"kind", "alarm"}, {"amount", 33}});
  EXPECT_EQ(process->wait(), 3);
  EXPECT_THAT(run_log(), AllOf(HasSubstr("alarm"), HasSubstr("33")));
  EXPECT_NE(capture("check " + with_rig()).exit_code, 0);
}

}  // namespace
}  // namespace raywalk
