// The Modbus slider on emulated serial ports, against the simulated drive. Needs the slave at
// /dev/ttyS1, the orders of serial_host.py at /dev/ttyS2, and /dev/slider linked to the USB adapter
// that was plugged in last. The tests run in their order: each begins where the one before ends.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "capture/base/test_fault.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "tests/kernel/require.h"

namespace raywalk::capture {
namespace {

// Starting a slave includes loading Python's libraries, possibly on a busy machine.
constexpr int kTimeout_ms = 60000;

// Connection to serial_host.py, which corrupts, cuts and unplugs the serial links on request.
class HostChannel {
 public:
  // Throws if the port cannot be opened.
  explicit HostChannel(const std::string& device)
      : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    require(fd_ >= 0, "cannot open " + device);
    termios settings{};
    tcgetattr(fd_, &settings);
    cfmakeraw(&settings);
    tcsetattr(fd_, TCSANOW, &settings);
  }
  ~HostChannel() { close(fd_); }
  HostChannel(const HostChannel&) = delete;
  HostChannel& operator=(const HostChannel&) = delete;

  // Sends an order (see serial_host.py) and waits until it is done; returns the number in the
  // reply. Throws if the order fails or there is no reply.
  int ask(const std::string& order) {
    const std::string line = order + "\n";
    require(write(fd_, line.data(), line.size()) == static_cast<ssize_t>(line.size()),
            "cannot write to the host's port");
    const std::string answer = read_line();
    require(answer.starts_with("done "), "the host failed to execute '" + order + "': " + answer);
    return std::stoi(answer.substr(5));
  }

 private:
  std::string read_line() {
    std::string line;
    for (;;) {
      pollfd input{.fd = fd_, .events = POLLIN, .revents = 0};
      require(poll(&input, 1, kTimeout_ms) > 0, "no reply from the host");
      char letter = 0;
      require(read(fd_, &letter, 1) == 1, "the host's port was closed");
      if (letter == '\n') return line;
      line += letter;
    }
  }

  int fd_;
};

const std::string kSerialPort = "/dev/ttyS1";
const std::string kOrders = "/dev/ttyS2";
const std::string kUsbAdapter = "/dev/slider";
const SoftLimits kLimits(0.0, 1000.0);
constexpr double kNear_mm = 0.02;

SliderConfig config_at(const std::string& device) {
  SliderConfig config;
  config.device = device;
  config.tries = 4;
  config.response_timeout_ms = 300.0;
  config.byte_timeout_ms = 200.0;
  config.register_map = RAYWALK_CONFIGS "/sliders/generic.yaml";
  return config;
}

MotionRules rules() {
  MotionRules rules;
  rules.profile = {200.0, 2000.0};
  rules.settle_ms = 100.0;
  rules.stall_ms = 5000.0;  // the virtual machine may be slow
  return rules;
}

// A slider session of one program, from opening to closing the port.
struct Rig {
  explicit Rig(const std::string& device) : slider(open_slider(config_at(device), &clock)) {}

  void move(double target_mm) {
    const SettledPosition settled = carriage.move_to(kLimits.require(target_mm, "test"));
    EXPECT_NEAR(settled.measured_mm, target_mm, kNear_mm);
    EXPECT_NEAR(slider->read_state().position_mm, target_mm, kNear_mm);
  }
  // Moves and sends an order to the host halfway.
  void move_with(HostChannel* host, const std::string& order, double target_mm) {
    const double halfway_mm = (slider->read_state().position_mm + target_mm) / 2.0;
    bool asked = false;
    carriage.watch([&, halfway_mm](WallTime /*time*/, double position_mm) {
      if (asked || position_mm < halfway_mm) return;
      asked = true;
      host->ask(order);
    });
    try {
      move(target_mm);
    } catch (...) {
      carriage.watch({});
      throw;
    }
    carriage.watch({});
    require(asked, "the move ended before its middle was observed");
  }

  SystemClock clock;
  std::unique_ptr<ModbusSlider> slider;
  Carriage carriage{slider.get(), &clock, kLimits, rules()};
};

void home_and_move(Rig* rig) {
  EXPECT_EQ(rig->slider->read_state().homed, false) << "claims to be homed from the start";
  rig->carriage.home();
  EXPECT_EQ(rig->slider->read_state().homed, true);
  for (const double target_mm : {150.0, 12.34, 12.5}) rig->move(target_mm);
}

class SliderTest : public ::testing::Test {
 protected:
  // A failed test may have left the link with a fault.
  void SetUp() override { host.ask("serial heal"); }
  // Contact is lost during a move: stops are sent, and the message says that none was confirmed.
  void expect_lost(Rig* rig, const std::string& order) {
    expect_fault(FaultKind::kNoContact, "NOT known to have stopped",
                 [&] { rig->move_with(&host, order, 900.0); });
  }
  void plug_adapter_in() {
    host.ask("usb plug");
    for (int tries = 0; tries < 600 && !std::filesystem::exists(kUsbAdapter); ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    EXPECT_TRUE(std::filesystem::exists(kUsbAdapter)) << "the adapter does not appear";
  }
  static void expect_no_adapter(Rig* rig) {
    expect_fault(FaultKind::kNoContact, "plug in the adapter", [&] { rig->slider->read_state(); });
  }

  HostChannel host{kOrders};
};
using SerialTest = SliderTest;
using UsbTest = SliderTest;

TEST_F(SerialTest, HomesMovesAndReadsBack) {
  Rig rig(kSerialPort);
  home_and_move(&rig);
}

TEST_F(SerialTest, PortThatAnotherProgramHolds) {
  Rig owner(kSerialPort);
  owner.slider->read_state();
  Rig other(kSerialPort);
  expect_fault(FaultKind::kNoContact, "in use by another program",
               [&] { other.slider->read_state(); });
}

// While one in a few replies has a fault; the host counts the faults.
TEST_F(SerialTest, MovesWithFaultyReplies) {
  for (const std::string fault :
       {"corrupt 3", "truncate 3", "lose 3", "double 2", "noise 3", "delay 7"}) {
    SCOPED_TRACE(fault);
    Rig rig(kSerialPort);
    rig.move(20.0);
    host.ask("serial " + fault);
    rig.move(120.0);
    EXPECT_GT(host.ask("serial heal"), 0) << "no reply had a fault";
    EXPECT_NEAR(rig.slider->read_state().position_mm, 120.0, kNear_mm);
  }
}

TEST_F(SerialTest, EveryReplyCorrupted) {
  Rig rig(kSerialPort);
  host.ask("serial corrupt 1");
  expect_fault(FaultKind::kNoContact, "Invalid CRC", [&] { rig.slider->read_state(); });
  host.ask("serial heal");
  rig.move(20.0);
}

TEST_F(SerialTest, CableCutDuringAMove) {
  Rig rig(kSerialPort);
  rig.move(20.0);
  const int stops_before = host.ask("serial stops");
  expect_lost(&rig, "serial cut");
  EXPECT_GT(host.ask("serial stops"), stops_before) << "no stop was sent over the cut cable";
  host.ask("serial heal");
  rig.carriage.stop();
  EXPECT_EQ(rig.slider->read_state().moving, false);
  rig.move(30.0);
}

TEST_F(SerialTest, DriveLosesPowerDuringAMove) {
  Rig rig(kSerialPort);
  rig.move(20.0);
  expect_lost(&rig, "serial kill");
  host.ask("serial start");
  expect_fault(FaultKind::kAlarm, "home first", [&] { rig.move(30.0); });
  rig.carriage.home();
  rig.move(30.0);
}

TEST_F(UsbTest, AdapterPluggedInHomesAndMoves) {
  Rig rig(kUsbAdapter);
  expect_no_adapter(&rig);
  plug_adapter_in();
  home_and_move(&rig);
}

TEST_F(UsbTest, AdapterPluggedInAgainDuringAMove) {
  Rig rig(kUsbAdapter);
  rig.move(20.0);
  rig.move_with(&host, "usb replug", 220.0);
}

TEST_F(UsbTest, AdapterUnpluggedDuringAMoveAndPluggedInLater) {
  Rig rig(kUsbAdapter);
  rig.move(20.0);
  expect_lost(&rig, "usb unplug");
  expect_no_adapter(&rig);
  plug_adapter_in();
  rig.carriage.stop();
  rig.move(30.0);
}

}  // namespace
}  // namespace raywalk::capture
