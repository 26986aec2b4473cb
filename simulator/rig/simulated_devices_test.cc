// The simulated drive and camera, and what serves them.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "simulator/rig/drive_server.h"
#include "simulator/rig/faults.h"
#include "simulator/rig/osc_server.h"
#include "simulator/rig/simulated_camera.h"
#include "simulator/rig/simulated_drive.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using namespace capture;
using Json = nlohmann::json;
using Words = std::vector<std::uint16_t>;
using enum RigFault;

constexpr MotionBounds kDriveBounds{100.0, 200.0, 200.0};

class SimulatedDriveTest : public ::testing::Test {
 protected:
  SimulatedDriveTest() { use({.backlash_mm = 0.0}); }

  // A homed drive of these settings.
  void use(const DriveSettings& settings) {
    drive.emplace(settings, &clock_, &faults_);
    drive->home();
    pass(60000.0);
  }
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  // Commands a move and lets time pass.
  void move(double target_mm, double ms) {
    drive->move_to(target_mm, kDriveBounds);
    pass(ms);
  }
  void expect_at(double feedback_mm, bool moving, double carriage_mm) {
    const DriveState state = drive->state();
    EXPECT_NEAR(state.feedback_mm, feedback_mm, 1e-6);
    EXPECT_EQ(state.moving, moving);
    EXPECT_EQ(state.in_position, !moving);
    EXPECT_NEAR(drive->truth().carriage_mm, carriage_mm, 1e-6);
  }
  void expect_at(double mm, bool moving = false) { expect_at(mm, moving, mm); }

  ManualClock clock_;
  Faults faults_{&clock_};
  std::optional<SimulatedDrive> drive;
};

TEST_F(SimulatedDriveTest, HomingMakesTheSwitchZeroFromBothOfItsSides) {
  for (const double power_on_mm : {300.0, -10.0}) {
    drive.emplace(DriveSettings{.power_on_mm = power_on_mm, .backlash_mm = 0.0}, &clock_, &faults_);
    EXPECT_FALSE(drive->state().homed);
    expect_at(0.0, false, power_on_mm);  // the drive does not know yet where it is
    drive->home();
    pass(100.0);
    EXPECT_TRUE(drive->state().moving);
    EXPECT_FALSE(drive->state().homed);
    pass(60000.0);
    EXPECT_TRUE(drive->state().homed);
    expect_at(0.0);
  }
}

// A reversal between two readings counts for the visited positions.
TEST_F(SimulatedDriveTest, ExtremesIncludeUnobservedReversals) {
  move(1000.0, 1500.0);  // at 125 mm, 100 mm/s: halts at 150 mm
  move(50.0, 60000.0);
  expect_at(50.0);
  const DriveTruth truth = drive->truth();
  EXPECT_NEAR(truth.visited.high_mm, 150.0, 1e-6);
  EXPECT_NEAR(truth.visited.low_mm, 0.0, 1e-9);
  EXPECT_EQ(truth.commanded.high_mm, 1000.0);
  EXPECT_EQ(truth.commanded.low_mm, 50.0);
  EXPECT_EQ(truth.moves, 2);
}

TEST_F(SimulatedDriveTest, NoiseHasTheGivenDeviationAndIsSeeded) {
  const DriveSettings settings{.backlash_mm = 0.0, .feedback_noise_mm = 0.05};
  SimulatedDrive noisy(settings, &clock_, &faults_), again(settings, &clock_, &faults_);
  double sum = 0.0, squares = 0.0;
  constexpr int kReadings = 4000;
  for (int i = 0; i < kReadings; ++i) {
    const double reading = noisy.state().feedback_mm;
    EXPECT_EQ(again.state().feedback_mm, reading);
    sum += reading;
    squares += reading * reading;
  }
  EXPECT_NEAR(sum / kReadings, 0.0, 0.005);
  EXPECT_NEAR(std::sqrt(squares / kReadings), 0.05, 0.003);
}

TEST_F(SimulatedDriveTest, StopDeceleratesAndStays) {
  move(1000.0, 2000.0);
  drive->stop();
  pass(60000.0);
  expect_at(177.5);  // 175 mm, then 100^2 / (2 * 2000) of braking
}

TEST_F(SimulatedDriveTest, LimitSwitchesStopTheMotorButAllowReturning) {
  move(5000.0, 60000.0);
  expect_at(2000.0);
  EXPECT_TRUE(drive->state().at_high_limit);
  move(6000.0, 1000.0);
  expect_at(2000.0);
  move(1900.0, 60000.0);
  expect_at(1900.0);
  EXPECT_FALSE(drive->state().at_high_limit);
  // A fault of the switch refuses its side only.
  faults_.add({.kind = kHighLimit, .for_ms = 10000.0});
  EXPECT_TRUE(drive->state().at_high_limit);
  move(1950.0, 2000.0);
  expect_at(1900.0);
  move(1800.0, 9000.0);
  expect_at(1800.0);
  EXPECT_FALSE(drive->state().at_high_limit);
}

TEST_F(SimulatedDriveTest, StalledMotorIsReportedAsMovingAndGoesOnWhenFreed) {
  move(400.0, 1000.0);
  faults_.add({.kind = kStall, .for_ms = 3000.0});
  pass(2000.0);
  expect_at(75.0, true);
  pass(60000.0);
  expect_at(400.0);
  faults_.add({.kind = kStall});
  move(10.0, 60000.0);
  expect_at(400.0, true);
  faults_.clear();
  drive->state();
  pass(60000.0);
  expect_at(10.0);
}

TEST_F(SimulatedDriveTest, AlarmHaltsUntilItIsReset) {
  move(400.0, 1000.0);
  faults_.add({.kind = kAlarm, .amount = 0x210});
  pass(5000.0);
  const DriveState state = drive->state();
  EXPECT_TRUE(state.alarm);
  EXPECT_FALSE(state.enabled || state.moving);
  move(300.0, 5000.0);
  EXPECT_EQ(drive->state().feedback_mm, state.feedback_mm);
  drive->reset_alarm();
  EXPECT_FALSE(drive->state().alarm);
  move(300.0, 60000.0);
  expect_at(300.0);
}

double log_uniform(std::mt19937* random, double min, double max) {
  return std::exp(std::uniform_real_distribution<double>(std::log(min), std::log(max))(*random));
}

// Position and speed are continuous; acceleration and speed stay within their bounds.
TEST(TrajectoryTest, AnyMotionIsContinuousAndWithinItsBounds) {
  std::mt19937 random(4);
  for (int i = 0; i < 5000; ++i) {
    const auto sign = [&] { return random() % 2 == 0 ? 1.0 : -1.0; };
    const MotionBounds bounds{log_uniform(&random, 1e-2, 1e4), log_uniform(&random, 1e-1, 1e5),
                              log_uniform(&random, 1e-1, 1e5)};
    const MotionState start{sign() * log_uniform(&random, 1e-3, 1e4),
                            i % 3 == 0 ? 0.0 : sign() * log_uniform(&random, 1e-2, 1e4)};
    const double target_mm = sign() * log_uniform(&random, 1e-3, 1e4);
    const auto move = Trajectory::to(target_mm, start, bounds);
    const double fastest = std::max(bounds.speed_mm_s, std::abs(start.speed_mm_s));
    MotionState before = start;
    double reach_mm = std::max(std::abs(start.position_mm), std::abs(target_mm));
    for (const Trajectory::Phase& phase : move.phases()) {
      reach_mm = std::max(reach_mm, std::abs(phase.start.position_mm));
      EXPECT_NEAR(phase.start.position_mm, before.position_mm, 1e-9 * reach_mm);
      EXPECT_NEAR(phase.start.speed_mm_s, before.speed_mm_s, 1e-7 * fastest);
      EXPECT_LE(std::abs(phase.start.speed_mm_s), fastest * (1.0 + 1e-9));
      EXPECT_LE(std::abs(phase.acceleration_mm_s2),
                std::max(bounds.acceleration_mm_s2, bounds.deceleration_mm_s2));
      before = {phase.start.position_mm +
                    (phase.start.speed_mm_s + 0.5 * phase.acceleration_mm_s2 * phase.duration_s) *
                        phase.duration_s,
                phase.start.speed_mm_s + phase.acceleration_mm_s2 * phase.duration_s};
    }
    EXPECT_NEAR(before.position_mm, target_mm, 1e-6 * reach_mm) << i;
    // A rounding error of the distance leaves a speed of its square root.
    EXPECT_NEAR(before.speed_mm_s, 0.0, 1e-6 * fastest) << i;
  }
}

// --- On its lines, with the slider driver, every shipped map and both links ----------------------
//
// Both sides use libmodbus; tests/peers has an independent peer.

bool eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    poll(nullptr, 0, 2);
  }
  return true;
}

// A drive in simulated time with a register map on both of its lines, and a configuration to reach
// it.
class ServedDrive {
 public:
  ServedDrive(const fs::path& map, SliderConnection connection) : map_(map) {
    config.connection = connection;
    config.device = link();
    config.host = "127.0.0.1";
    config.port = server.tcp_port();
    config.register_map = map;
    config.response_timeout_ms = 100.0;
    config.byte_timeout_ms = 50.0;
    config.tries = 5;
  }
  fs::path link() const { return directory_ / "slider"; }

 private:
  const TestDirectory directory_;
  const fs::path map_;

 public:
  ManualClock clock;
  Faults faults{&clock, {.late_ms = 150.0}};
  SimulatedDrive drive{
      {.power_on_mm = 30.0, .backlash_mm = 0.0, .feedback_noise_mm = 0.01}, &clock, &faults};
  DriveServer server{{1, link(), 0}, read_register_map(map_), &drive, &faults};
  SliderConfig config;
};

// Leadshine's map: one block starts a move with its last word; home and stop share a register.
class DriveServerTest : public ::testing::Test {
 protected:
  DriveServerTest() { rig_.config.response_timeout_ms = 20000.0; }

  ModbusLink link(SliderConnection connection = SliderConnection::kTcp, int unit = 1) {
    SliderConfig config = rig_.config;
    config.connection = connection;
    config.unit = unit;
    return {config, &rig_.clock};
  }
  // Whether a link reads the position.
  bool answers(SliderConnection connection) {
    return link(connection).read(RegisterKind::kHolding, 0x1014, 2).size() == 2;
  }

  ServedDrive rig_{RAYWALK_CONFIGS "/sliders/leadshine-pr0.yaml", SliderConnection::kRtu};
};

// A killed client that held the port exclusively must not lock out the next one.
TEST_F(DriveServerTest, ExclusiveUseEndsWithTheClient) {
  const int terminal = open(rig_.link().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(ioctl(terminal, TIOCEXCL), 0);
  EXPECT_TRUE(eventually([terminal] {
    int exclusive = 1;
    ioctl(terminal, TIOCGEXCL, &exclusive);
    return exclusive == 0;
  }));
  close(terminal);
}

TEST_F(DriveServerTest, BroadcastsAreExecutedAndOtherUnitsIgnored) {
  const int terminal = open(rig_.link().c_str(), O_RDWR | O_NOCTTY);
  // To unit 0; the last two bytes are the checksum.
  const std::array<std::uint8_t, 8> home{0, 6, 0x60, 0x02, 0, 0x20, 0x36, 0x03};
  ASSERT_EQ(write(terminal, home.data(), home.size()), static_cast<ssize_t>(home.size()));
  EXPECT_TRUE(eventually([&] {
    rig_.clock.sleep(std::chrono::milliseconds(100));
    return rig_.drive.state().homed;
  }));
  close(terminal);
  rig_.config.response_timeout_ms = 60.0;
  rig_.config.tries = 1;
  expect_fault(FaultKind::kNoContact, "unit 2",
               [&] { link(SliderConnection::kRtu, 2).read(RegisterKind::kHolding, 0x1014, 2); });
  EXPECT_EQ(rig_.faults.exchanges(), 1U);
}

TEST_F(DriveServerTest, WritesThatMoveNothingAreRefusedOrStored) {
  ModbusLink client = link();
  expect_fault(FaultKind::kWrongDevice, "Illegal data address",
               [&] { client.read(RegisterKind::kInput, 0x1014, 2); });
  // At speed 0, to a position that is not that of the drive.
  expect_fault(FaultKind::kWrongDevice, "Illegal data value", [&] {
    client.write(0x6200, Words{1, 0, 1, 0, 5000, 5000, 0, 0x10});
  });
  // Without the trigger.
  EXPECT_TRUE(client.write(0x6200, Words{1, 0, 7000, 150, 5000, 5000, 0, 0}));
  EXPECT_TRUE(client.write(0x6200, Words{1}));
  EXPECT_EQ(client.read(RegisterKind::kHolding, 0x6202, 1), Words{7000});
  EXPECT_EQ(rig_.drive.truth().moves, 0);
}

TEST_F(DriveServerTest, LateReplyArrivesAfterTheTimeout) {
  rig_.config.response_timeout_ms = 60.0;
  rig_.config.tries = 1;
  rig_.faults.add({.kind = kLate});
  EXPECT_THROW(answers(SliderConnection::kRtu), DeviceFault);
}

TEST_F(DriveServerTest, MisbehavingClientsDoNotAffectOthers) {
  ModbusLink good = link();
  good.read(RegisterKind::kHolding, 0x1014, 2);
  // A browser that takes it for a web server.
  EXPECT_FALSE(httplib::Client("127.0.0.1", rig_.config.port).Get("/"));
  const int terminal = open(rig_.link().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GT(write(terminal, "\x01\x03\x10", 3), 0);  // half a request
  close(terminal);
  poll(nullptr, 0, 30);
  EXPECT_EQ(good.read(RegisterKind::kHolding, 0x1014, 2).size(), 2U);
  EXPECT_TRUE(answers(SliderConnection::kRtu));
}

TEST_F(DriveServerTest, PortOrNameInUseIsAnError) {
  for (const DriveServerSettings& settings : {DriveServerSettings{1, {}, rig_.server.tcp_port()},
                                              {1, rig_.link().parent_path(), {}},
                                              {1, rig_.link() / "no/slider", {}}}) {
    EXPECT_THROW(DriveServer(settings, RegisterMap{}, &rig_.drive, &rig_.faults), Error);
  }
}

// --- The driver ----------------------------------------------------------------------------------

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
    "status:\n  alarm: {bit: 3, active_low: true}\n  moving: {bit: 0}\n  homed: {bit: 1}\n";

struct Setup {
  std::string map;
  SliderConnection connection;
};

class SliderOnRigTest : public ::testing::TestWithParam<Setup> {
 protected:
  SliderOnRigTest() : rig_(map_file(), GetParam().connection) { carriage_.home(); }

  fs::path map_file() const {
    if (GetParam().map != kVariants) return fs::path(RAYWALK_CONFIGS "/sliders") / GetParam().map;
    write_file_atomically(directory_ / kVariants, kVariantsText);
    return directory_ / kVariants;
  }
  void go_to(double mm, double tolerance_mm) {
    const auto settled = carriage_.move_to(limits_.require(mm, "test"));
    EXPECT_NEAR(settled.measured_mm, mm, tolerance_mm);
    EXPECT_NEAR(rig_.drive.truth().carriage_mm, mm, 0.01);
    EXPECT_FALSE(rig_.drive.state().moving);
  }
  void expect_failing_move(FaultKind kind) {
    expect_fault(kind, "", [&] { go_to(800.0, 0.0); });
  }
  // A request to come.
  int request(int number) const { return static_cast<int>(rig_.faults.exchanges()) + number; }

  const TestDirectory directory_;
  ServedDrive rig_;
  const SoftLimits limits_{0.0, 1000.0};
  const std::unique_ptr<ModbusSlider> slider_ = open_slider(rig_.config, &rig_.clock);
  Carriage carriage_{slider_.get(), &rig_.clock, limits_, {.poll_ms = 50.0}};
};

TEST_P(SliderOnRigTest, HomesAndReachesEveryTargetAlsoAfterAnAlarm) {
  EXPECT_NEAR(rig_.drive.truth().carriage_mm, 0.0, 1e-6);
  for (const double target_mm : {25.0, 90.0, 0.0, 51.24}) go_to(target_mm, 0.05);
  rig_.faults.add({.kind = kAlarm, .amount = 0x21, .after_ms = 500.0});
  expect_failing_move(FaultKind::kAlarm);
  rig_.drive.reset_alarm();
  go_to(10.0, 0.05);
}

TEST_P(SliderOnRigTest, LinkCutDuringAMoveIsAFaultAndCanReconnect) {
  rig_.faults.add({.kind = kCut, .at_request = request(8)});
  expect_failing_move(FaultKind::kNoContact);
  rig_.faults.clear();
  // The new port appears shortly, in real time.
  EXPECT_TRUE(eventually([this] { return fs::exists(rig_.link()); }));
  carriage_.stop();
  go_to(20.0, 0.1);
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
                         [](const auto& test) {
                           const std::string map = fs::path(test.param.map).stem().string();
                           return std::regex_replace(map, std::regex("-"), "_") + "_" +
                                  std::string(name_of(test.param.connection));
                         });

// --- The camera ----------------------------------------------------------------------------------

class SimulatedCameraTest : public testing::Test {
 protected:
  SimulatedCameraSettings settings() const {
    return {.card_directory = directory_ / "card", .frame = {64, 32}};
  }
  OscReply execute(const std::string& name, const Json& parameters = Json::object()) {
    return camera_.execute(Json{{"name", name}, {"parameters", parameters}}.dump());
  }
  // The error's code, or "done" and the like.
  std::string outcome(const std::string& name, const Json& parameters = Json::object()) {
    const Json reply = execute(name, parameters).json;
    return reply.contains("error") ? reply["error"]["code"] : reply["state"];
  }
  std::string set(const Json& options) {
    return outcome("camera.setOptions", {{"options", options}});
  }
  // The gain of a new picture.
  double shoot() {
    execute("camera.takePicture");
    clock_.sleep(capture::duration_from_ms(200.0));
    return gain_;
  }

  TestDirectory directory_;
  capture::ManualClock clock_;
  Faults faults_{&clock_};
  double gain_ = 0.0;
  SimulatedCamera camera_{settings(), &clock_, &faults_, [this](const ExposureNow& exposure) {
                            gain_ = exposure.gain;
                            return std::string("\xff\xd8\xff\xd9");
                          }};
};

TEST_F(SimulatedCameraTest, RefusesAsTheApiDocuments) {
  EXPECT_EQ(execute("camera.explode").http_status, 400);
  EXPECT_EQ(outcome("camera.explode"), "unknownCommand");
  EXPECT_EQ(outcome("camera.getOptions", {{"optionNames", {"iso", "_none"}}}),
            "invalidParameterName");
  EXPECT_EQ(outcome("camera.setOptions"), "missingParameter");
  EXPECT_EQ(set({{"iso", "many"}}), "invalidParameterValue");
  EXPECT_EQ(outcome("camera.takePicture"), "inProgress");
  EXPECT_EQ(execute("camera.takePicture").http_status, 403);
  EXPECT_EQ(camera_.execute("no JSON").http_status, 400);
}

TEST_F(SimulatedCameraTest, OptionsAreThoseOfTheTable) {
  EXPECT_EQ(set({{"exposureProgram", 1}, {"iso", 200}}), "done");
  EXPECT_EQ(camera_.options().at("shutterSpeed"), 0.01666666) << "the metered one";
  EXPECT_NEAR(shoot(), 2.0, 1e-6);
  EXPECT_EQ(set({{"iso", 100}}), "done");
  EXPECT_NEAR(shoot(), 1.0, 1e-6);
  const Json before = camera_.options();
  for (const Json& wrong : {Json{{"iso", 101}}, Json{{"shutterSpeed", 0.0123}},
                            Json{{"_colorTemperature", 5050}}, Json{{"captureMode", "video"}}}) {
    EXPECT_EQ(set(wrong), "invalidParameterValue") << wrong;
  }
  EXPECT_EQ(set({{"iso", 200}, {"_none", 1}}), "invalidParameterName");
  EXPECT_EQ(camera_.options(), before) << "a refused command changes nothing";
  EXPECT_EQ(set({{"exposureProgram", 2}}), "done");
  EXPECT_EQ(camera_.options().at("iso"), 0);
}

TEST_F(SimulatedCameraTest, NamesContinueAfterTheFilesOnTheCard) {
  shoot();
  std::ofstream(directory_ / "card/R0010007.JPG") << "a picture";
  SimulatedCamera again(settings(), &clock_, &faults_, [](const auto&) { return "\xff\xd8"; });
  EXPECT_EQ(again.file("R0010001.JPG"), camera_.file("R0010001.JPG"));
  again.execute(R"({"name": "camera.takePicture"})");
  EXPECT_NO_THROW(again.file("R0010008.JPG"));
}

TEST_F(SimulatedCameraTest, ServersPortInUseIsAnError) {
  const OscServer server(&camera_, &faults_, 0);
  EXPECT_THROW(OscServer(&camera_, &faults_, server.port()), Error);
}

// --- Faults --------------------------------------------------------------------------------------

class FaultsTest : public ::testing::Test {
 protected:
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }
  bool lasts(RigFault kind) const { return faults_.lasting(kind).has_value(); }

  ManualClock clock_;
  Faults faults_{&clock_};
};

TEST_F(FaultsTest, PermanentOnesLastUntilMendedOthersOccurOnce) {
  faults_.add({.kind = kStall});
  faults_.add({.kind = kEmptyPicture});
  pass(1e6);
  EXPECT_TRUE(lasts(kStall));
  EXPECT_FALSE(lasts(kEmptyPicture));
  EXPECT_TRUE(faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.occurs(kEmptyPicture));
  faults_.clear();
  EXPECT_FALSE(lasts(kStall));
}

TEST_F(FaultsTest, DelayAndDurationAreKept) {
  for (const RigFault kind : {kStall, kEmptyPicture}) {
    faults_.add({.kind = kind, .amount = 7.0, .for_ms = 100.0, .after_ms = 50.0});
  }
  EXPECT_FALSE(lasts(kStall) || faults_.occurs(kEmptyPicture));
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(50.0));
  pass(50.0);
  EXPECT_EQ(faults_.lasting(kStall)->amount, 7.0);
  EXPECT_EQ(faults_.lasting(kStall)->since, clock_.now());
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.occurs(kEmptyPicture), 7.0);
  EXPECT_EQ(faults_.next_change(clock_.now()), clock_.now() + duration_from_ms(100.0));
  pass(100.0);
  EXPECT_FALSE(lasts(kStall) || faults_.occurs(kEmptyPicture));
  EXPECT_FALSE(faults_.next_change(clock_.now()));
}

TEST_F(FaultsTest, EveryTriggerBeginsItsFault) {
  const std::vector<RigFault> kinds{kStall, kBusy, kCut, kLowLimit};
  faults_.add({.kind = kStall, .at_request = 2});
  faults_.add({.kind = kBusy, .at_picture = 3});
  faults_.add({.kind = kCut, .at_station = "x0_001"});
  faults_.add({.kind = kLowLimit, .at_s = 10.0});
  faults_.next_exchange();
  faults_.picture_triggered(2);
  faults_.move_commanded("x0_002");
  pass(9999.0);
  for (const RigFault kind : kinds) EXPECT_FALSE(lasts(kind));
  faults_.next_exchange();
  faults_.picture_triggered(3);
  faults_.move_commanded("x0_001");
  pass(1.0);
  for (const RigFault kind : kinds) EXPECT_TRUE(lasts(kind));
}

// They depend on the seed alone; those that are added do not change the random sequence.
TEST_F(FaultsTest, RandomOnesHaveTheGivenRatesAndRepeatForASeed) {
  const LinkSettings link{.late = 0.02, .lost = 0.02, .corrupted = 0.02, .duplicated = 0.02};
  Faults faults(&clock_, link), again(&clock_, link);
  again.add({.kind = kLostReply, .at_request = 10});
  again.add({.kind = kDuplicated});
  std::map<RigFault, int> counts;
  std::uint64_t all = 0;
  constexpr int kRequests = 20000;
  for (int request = 1; request <= kRequests; ++request) {
    const auto fault = faults.next_exchange(), repeated = again.next_exchange();
    EXPECT_EQ(repeated, request == 1    ? std::optional(kDuplicated)
                        : request == 10 ? std::optional(kLostReply)
                                        : fault);
    if (!fault) continue;
    ++counts[*fault];
    ++all;
  }
  for (const auto& [kind, share] :
       {std::pair{kLate, 0.02}, std::pair{kDuplicated, 0.02}, std::pair{kLostRequest, 0.02},
        std::pair{kLostReply, 0.01}, std::pair{kCorruptedReply, 0.01}}) {
    EXPECT_NEAR(counts[kind], share * kRequests, 0.2 * share * kRequests) << name_of(kind);
  }
  EXPECT_EQ(faults.exchanges(), 20000U);
  EXPECT_EQ(faults.occurred(), all);
}

}  // namespace
}  // namespace raywalk::simulator
