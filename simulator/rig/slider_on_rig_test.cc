// The slider driver against the simulated drive, with every shipped register map and both links.
// Both sides use libmodbus; tests/peers has an independent peer.
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <string>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "simulator/rig/drive_server.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

// What no shipped map has: state in input registers, low word first, an active-low flag.
constexpr const char* kVariants = "variants.yaml";
constexpr const char* kVariantsText =
    "name: variants\nsteps_per_mm: 1000\nlow_word_first: true\ninput_registers: true\n"
    "position_address: 2\nstatus_address: 1\nalarm_address: 4\n"
    "speed_per_mm_s: 1000\nacceleration_per_mm_s2: 10\n"
    "move:\n  address: 100\n"
    "  words: [position_low, position_high, speed_low, speed_high, acceleration]\n"
    "start:\n  address: 110\n  words: [1]\n"
    "home:\n  address: 111\n  words: [1]\n"
    "stop:\n  address: 112\n  words: [1]\n"
    "reset_alarm:\n  address: 113\n  words: [1]\n"
    "status:\n  alarm: {bit: 3, active_low: true}\n  moving: {bit: 0}\n  homed: {bit: 1}\n";

struct Setup {
  std::string map;
  SliderConnection connection;
};

class SliderOnRigTest : public ::testing::TestWithParam<Setup> {
 protected:
  void SetUp() override { carriage_.home(); }
  std::filesystem::path map_file() const {
    if (GetParam().map != kVariants) {
      return std::filesystem::path(RAYWALK_CONFIGS) / "sliders" / GetParam().map;
    }
    write_file_atomically(directory_ / kVariants, kVariantsText);
    return directory_ / kVariants;
  }
  static DriveSettings drive_settings() {
    DriveSettings settings;
    settings.backlash_mm = 0.0;
    settings.power_on_mm = 30.0;
    settings.feedback_noise_mm = 0.01;
    return settings;
  }
  SliderConfig slider_config() const {
    SliderConfig config;
    config.connection = GetParam().connection;
    config.device = (directory_ / "slider").string();
    config.host = "127.0.0.1";
    config.port = server_.tcp_port();
    config.register_map = map_file();
    config.response_timeout_ms = 100.0;
    config.byte_timeout_ms = 50.0;
    config.tries = 5;
    return config;
  }
  static MotionRules rules() {
    MotionRules rules;
    rules.poll_ms = 50.0;
    return rules;
  }

  const TestDirectory directory_;
  ManualClock clock_;
  Faults faults_{&clock_, {.late_ms = 150.0}};
  SimulatedDrive drive_{drive_settings(), &clock_, &faults_};
  DriveServer server_{
      {1, directory_ / "slider", 0}, read_register_map(map_file()), &drive_, &faults_};
  const SoftLimits limits_{0.0, 1000.0};
  const std::unique_ptr<Slider> slider_ = make_modbus_slider(slider_config(), &clock_);
  Carriage carriage_{slider_.get(), &clock_, limits_, rules()};
};

TEST_P(SliderOnRigTest, HomesAndReachesEveryTarget) {
  EXPECT_NEAR(drive_.truth().carriage_mm, 0.0, 1e-6);
  for (const double target_mm : {25.0, 90.0, 0.0, 51.24}) {
    const auto settled = carriage_.move_to(limits_.require(target_mm, "test"));
    EXPECT_NEAR(settled.measured_mm, target_mm, 0.05);
    EXPECT_NEAR(drive_.truth().carriage_mm, target_mm, 0.01);
    EXPECT_FALSE(drive_.state().moving);
  }
}

TEST_P(SliderOnRigTest, AlarmEndsTheMoveAndCanBeReset) {
  faults_.add({.kind = RigFault::kAlarm, .amount = 0x21, .after_ms = 500.0});
  try {
    carriage_.move_to(limits_.require(800.0, "test"));
    ADD_FAILURE() << "the alarm went unnoticed";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kAlarm) << fault.what();
  }
  slider_->reset_alarm();
  carriage_.move_to(limits_.require(10.0, "test"));
  EXPECT_NEAR(drive_.truth().carriage_mm, 10.0, 0.01);
}

TEST_P(SliderOnRigTest, FaultyLinkNeverCausesAWrongPosition) {
  // The serial line keeps real pauses between frames, which take real time.
  const int moves = GetParam().connection == SliderConnection::kTcp ? 24 : 6;
  for (int i = 0; i < moves; ++i) {
    // One of the first four exchanges of each move has a fault, cycling through all kinds.
    constexpr std::array kKinds{RigFault::kLostRequest, RigFault::kLostReply,
                                RigFault::kCorruptedReply, RigFault::kLate, RigFault::kDuplicated};
    faults_.add({.kind = kKinds.at(static_cast<std::size_t>(i) % kKinds.size()),
                 .at_request = static_cast<int>(faults_.exchanges()) + 1 + i % 4});
    const double target_mm = 10.0 * (i % 2 == 0 ? i : moves - 1 - i);
    const auto settled = carriage_.move_to(limits_.require(target_mm, "test"));
    EXPECT_NEAR(settled.measured_mm, target_mm, 0.1);
    EXPECT_NEAR(drive_.truth().carriage_mm, target_mm, 0.01) << i;
  }
  EXPECT_EQ(faults_.occurred(), static_cast<unsigned>(moves));
  EXPECT_GE(drive_.truth().commanded.low_mm, 0.0);
  EXPECT_LE(drive_.truth().visited.high_mm, 1000.0);
}

TEST_P(SliderOnRigTest, LinkCutDuringAMoveIsAFaultAndCanReconnect) {
  faults_.add({.kind = RigFault::kCut, .at_request = static_cast<int>(faults_.exchanges()) + 8});
  try {
    carriage_.move_to(limits_.require(800.0, "test"));
    ADD_FAILURE() << "the cut went unnoticed";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kNoContact) << fault.what();
  }
  faults_.clear();
  // The new port appears shortly, in real time.
  for (int i = 0; i < 400 && !std::filesystem::exists(directory_ / "slider"); ++i) {
    SystemClock().sleep(duration_from_ms(5.0));
  }
  carriage_.stop();
  carriage_.move_to(limits_.require(20.0, "test"));
  EXPECT_NEAR(drive_.truth().carriage_mm, 20.0, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Maps, SliderOnRigTest,
                         ::testing::Values(Setup{"leadshine-pr0.yaml", SliderConnection::kRtu},
                                           Setup{"oriental-az.yaml", SliderConnection::kRtu},
                                           Setup{"leadshine-pr0.yaml", SliderConnection::kTcp},
                                           Setup{"iai-block.yaml", SliderConnection::kRtu},
                                           Setup{"iai-block.yaml", SliderConnection::kTcp},
                                           Setup{"generic.yaml", SliderConnection::kRtu},
                                           Setup{"generic.yaml", SliderConnection::kTcp},
                                           Setup{kVariants, SliderConnection::kTcp}),
                         [](const ::testing::TestParamInfo<Setup>& param) {
                           std::string name = param.param.map + "_";
                           name += name_of(param.param.connection);
                           for (char& c : name)
                             c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace raywalk::simulator
