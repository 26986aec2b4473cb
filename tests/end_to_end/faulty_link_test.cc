// A thousand stations over a link that loses, delays, corrupts and duplicates messages, in
// simulated time: driver, carriage, sequence and session against the simulated drive.
#include <gmock/gmock.h>

#include <cmath>

#include "capture/run/capture_sequence.h"
#include "capture/run/fake_camera.h"
#include "capture/session/session_database.h"
#include "capture/session/test_session.h"
#include "capture/slider/modbus_slider.h"
#include "core/files/test_support.h"
#include "simulator/rig/drive_server.h"

namespace raywalk::capture {
namespace {

using namespace simulator;
using ::testing::HasSubstr;

// The serial line keeps real pauses between frames, which take real time.
struct Setup {
  SliderConnection connection;
  int stations;
};

constexpr double kFault = 0.02;  // share of exchanges, of each kind

class FaultyLinkTest : public ::testing::TestWithParam<Setup> {
 protected:
  static DriveSettings drive_settings() {
    return {.power_on_mm = 30.0,
            .max_speed_mm_s = 2000.0,
            .max_acceleration_mm_s2 = 20000.0,
            .homing_speed_mm_s = 500.0,
            .backlash_mm = 0.0,
            .feedback_noise_mm = 0.01};
  }
  SliderConfig slider_config() const {
    SliderConfig config;
    config.connection = GetParam().connection;
    config.device = (directory_ / "slider").string();
    config.host = "127.0.0.1";
    config.port = server_.tcp_port();
    config.register_map = map_;
    config.response_timeout_ms = 10.0;
    config.byte_timeout_ms = 5.0;
    config.tries = 5;
    return config;
  }
  // One run of the program; returns the reason of a pause, if any.
  std::string run() {
    const auto session = capture_.open();
    const auto slider = open_slider(slider_config(), &capture_.clock);
    Carriage carriage(slider.get(), &capture_.clock, limits_,
                      {.profile = {1000.0, 20000.0}, .settle_ms = 100.0, .poll_ms = 40.0});
    try {
      carriage.home();
      CaptureSequence({&carriage, &camera_, session.get(), [](auto&&...) {}, &capture_.clock}, {})
          .run(capture_.plan);
    } catch (const DeviceFault& fault) {
      return std::string("home: ") + fault.what();
    } catch (const Paused& paused) {
      return paused.what();
    }
    return "";
  }

  const TestDirectory directory_;
  const std::filesystem::path map_ =
      std::filesystem::path(RAYWALK_CONFIGS) / "sliders" / "leadshine-pr0.yaml";
  TestCapture capture_{.directory = directory_ / "session"};
  Faults faults_{&capture_.clock,
                 {.seed = 5,
                  .late = kFault,
                  .lost = kFault,
                  .corrupted = kFault,
                  .duplicated = kFault,
                  .late_ms = 14.0}};
  SimulatedDrive drive_{drive_settings(), &capture_.clock, &faults_};
  DriveServer server_{{1, directory_ / "slider", 0}, read_register_map(map_), &drive_, &faults_};
  const SoftLimits limits_{0.0, 1900.0};
  FakeCamera camera_{&capture_.clock};
};

TEST_P(FaultyLinkTest, AllStationsAreCapturedAtTheirPositions) {
  capture_.plan = {};
  for (int i = 0; i < 4; ++i) {
    capture_.plan.lines.push_back(test_line("x" + std::to_string(i), LineAxis::kX, 0.1 * i, 0.0,
                                            0.005, GetParam().stations / 4));
  }
  int shot_off_station = 0;
  camera_.on_shot = [&] {
    const double off_grid = std::remainder(drive_.truth().carriage_mm - kTestFirst_mm, 5.0);
    if (std::abs(off_grid) > 0.15 || drive_.state().moving) ++shot_off_station;
  };
  int pauses = 0;
  for (std::string paused = run(); !paused.empty(); paused = run()) {
    EXPECT_THAT(paused, HasSubstr(";"));
    ASSERT_LT(++pauses, 10) << paused;
  }
  EXPECT_EQ(shot_off_station, 0);
  int captured = 0;
  const SessionContents contents = SessionReader(capture_.directory).contents();
  for (const SessionStation& station : contents.stations) {
    ASSERT_TRUE(station.shot) << station.name;
    ++captured;
    EXPECT_NEAR(station.shot->measured_mm, station.planned_mm, 0.1);
  }
  EXPECT_EQ(captured, GetParam().stations);
  EXPECT_GE(drive_.truth().commanded.low_mm, limits_.low_mm());
  EXPECT_LE(drive_.truth().commanded.high_mm, limits_.high_mm());
  EXPECT_GE(drive_.truth().visited.low_mm, limits_.low_mm() - 0.1);
  EXPECT_LE(drive_.truth().visited.high_mm, limits_.high_mm());
  // Enough faults occurred for a meaningful test.
  EXPECT_GT(faults_.occurred(), 0.06 * static_cast<double>(faults_.exchanges()));
}

INSTANTIATE_TEST_SUITE_P(Links, FaultyLinkTest,
                         ::testing::Values(Setup{SliderConnection::kTcp, 1000},
                                           Setup{SliderConnection::kRtu, 200}),
                         [](const ::testing::TestParamInfo<Setup>& param) {
                           return std::string(name_of(param.param.connection));
                         });

}  // namespace
}  // namespace raywalk::capture
