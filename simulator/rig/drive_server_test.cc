// The simulated drive on its lines, and the slider driver against it, with every shipped register
// map and both links. Both sides use libmodbus; tests/peers has an independent peer.
#include "simulator/rig/drive_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

namespace fs = std::filesystem;
using Words = std::vector<std::uint16_t>;

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
  rig_.faults.add({.kind = RigFault::kLate});
  EXPECT_THROW(answers(SliderConnection::kRtu), DeviceFault);
}

TEST_F(DriveServerTest, MisbehavingClientsDoNotAffectOthers) {
  ModbusLink good = link();
  good.read(RegisterKind::kHolding, 0x1014, 2);
  modbus_t* const rude = modbus_new_tcp("127.0.0.1", rig_.config.port);
  ASSERT_EQ(modbus_connect(rude), 0);
  const std::string http = "GET / HTTP/1.1\r\n\r\n";
  ASSERT_GT(write(modbus_get_socket(rude), http.data(), http.size()), 0);
  pollfd closed{modbus_get_socket(rude), POLLIN, 0};
  EXPECT_EQ(poll(&closed, 1, 20000), 1);
  std::uint8_t byte = 0;
  EXPECT_LE(read(closed.fd, &byte, 1), 0);
  modbus_close(rude);
  modbus_free(rude);
  const int terminal = open(rig_.link().c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GT(write(terminal, "\x01\x03\x10", 3), 0);  // half a request
  close(terminal);
  poll(nullptr, 0, 30);
  EXPECT_EQ(good.read(RegisterKind::kHolding, 0x1014, 2).size(), 2U);
  EXPECT_TRUE(answers(SliderConnection::kRtu));
}

TEST_F(DriveServerTest, PortOrNameInUseIsAnError) {
  for (const DriveServerSettings& settings :
       {DriveServerSettings{1, {}, rig_.server.tcp_port()},
        DriveServerSettings{1, rig_.link().parent_path(), {}},
        DriveServerSettings{1, rig_.link() / "no/slider", {}}}) {
    EXPECT_THROW(DriveServer(settings, RegisterMap{}, &rig_.drive, &rig_.faults), Error);
  }
}

// --- The driver ---------------------------------------------------------------------------------

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
    const DeviceFault fault = fault_of([&] { go_to(800.0, 0.0); });
    EXPECT_EQ(fault.kind(), kind) << fault.what();
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
  rig_.faults.add({.kind = RigFault::kAlarm, .amount = 0x21, .after_ms = 500.0});
  expect_failing_move(FaultKind::kAlarm);
  rig_.drive.reset_alarm();
  go_to(10.0, 0.05);
}

TEST_P(SliderOnRigTest, LinkCutDuringAMoveIsAFaultAndCanReconnect) {
  rig_.faults.add({.kind = RigFault::kCut, .at_request = request(8)});
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
                         [](const ::testing::TestParamInfo<Setup>& param) {
                           std::string name = param.param.map + "_";
                           name += name_of(param.param.connection);
                           for (char& c : name)
                             c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace raywalk::simulator
