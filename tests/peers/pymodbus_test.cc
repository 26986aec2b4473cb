// The slider driver against pymodbus, an independent Modbus implementation.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <ostream>
#include <regex>
#include <stdexcept>
#include <string>
#include <thread>

#include "capture/base/test_fault.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::capture {
namespace {

const SoftLimits kLimits(0.0, 1000.0);

// The pymodbus slave in a process of its own, for tests that kill it.
class SlaveProcess {
 public:
  // Returns when it is ready. Throws std::runtime_error if it does not start.
  SlaveProcess(const std::string& map, const std::string& line)
      // Debian's interpreter, the only one for which the packages are installed.
      : process_({"/usr/bin/python3", RAYWALK_PYMODBUS_SLAVE, "--map", map, "--line", line}, log_) {
    std::string said;
    std::smatch ready;
    while (!std::regex_search(said, ready, std::regex("ready (\\S+)\n"))) {
      if (process_.has_ended()) {
        throw std::runtime_error(
            "the pymodbus slave does not start; scripts/install-packages test installs what it "
            "needs");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      said = read_file(log_);
    }
    where_ = ready[1];
    // Once both sides of a terminal are closed, the kernel reuses its number. A link that
    // reconnects after a hang-up would then reach the device of another test.
    if (where_.starts_with("/dev/"))
      terminal_ = open(where_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  ~SlaveProcess() {
    process_.signal(SIGKILL);
    process_.wait();
    if (terminal_ >= 0) close(terminal_);
  }
  SlaveProcess(const SlaveProcess&) = delete;
  SlaveProcess& operator=(const SlaveProcess&) = delete;

  // The device path of its pseudo-terminal, or its TCP port.
  const std::string& where() const { return where_; }
  void send(int signal) const { process_.signal(signal); }

 private:
  TestDirectory directory_;
  std::filesystem::path log_ = directory_ / "log";
  BackgroundProcess process_;
  std::string where_;
  int terminal_ = -1;
};

SliderConfig config_for(const SlaveProcess& slave, const std::string& line,
                        const std::string& map) {
  SliderConfig config;
  config.connection = line == "tcp" ? SliderConnection::kTcp : SliderConnection::kRtu;
  config.host = "127.0.0.1";
  if (line == "tcp") config.port = std::stoi(slave.where());
  config.device = slave.where();
  config.response_timeout_ms = 200.0;
  config.byte_timeout_ms = 100.0;
  config.tries = 10;  // the machine may be busy
  config.register_map = std::string(RAYWALK_CONFIGS "/sliders/") + map + ".yaml";
  return config;
}

const MotionRules kQuick{.profile = {2000.0, 20000.0}, .settle_ms = 50.0};

struct Peer {
  std::string map;
  std::string line;
};
void PrintTo(const Peer& peer, std::ostream* out) { *out << peer.map << " over " << peer.line; }

class PymodbusTest : public ::testing::TestWithParam<Peer> {
 protected:
  SlaveProcess slave{GetParam().map, GetParam().line};
  SystemClock clock;
  std::unique_ptr<ModbusSlider> slider =
      open_slider(config_for(slave, GetParam().line, GetParam().map), &clock);
  Carriage carriage{slider.get(), &clock, kLimits, kQuick};
};

TEST_P(PymodbusTest, HomesMovesAndReadsBack) {
  EXPECT_EQ(slider->read_state().homed, false);
  carriage.home();
  EXPECT_EQ(slider->read_state().homed, true);
  for (const double target_mm : {300.0, 12.34, 12.5}) {
    const SettledPosition settled = carriage.move_to(kLimits.require(target_mm, "test"));
    EXPECT_NEAR(settled.measured_mm, target_mm, 0.01);
    EXPECT_NEAR(slider->read_state().position_mm, target_mm, 0.01);
  }
}

TEST_P(PymodbusTest, StopsDuringAMove) {
  carriage.home();
  slider->start_move(kLimits.require(1000.0, "test"), MotionProfile{100.0, 2000.0});
  while (slider->read_state().position_mm < 5.0) {
  }
  carriage.stop();
  EXPECT_EQ(slider->read_state().moving, false);
  EXPECT_LT(slider->read_state().position_mm, 900.0);
}

INSTANTIATE_TEST_SUITE_P(Peers, PymodbusTest,
                         ::testing::Values(Peer{"generic", "pty"}, Peer{"generic", "tcp"},
                                           Peer{"leadshine-pr0", "pty"},
                                           Peer{"leadshine-pr0", "tcp"}),
                         [](const auto& test) {
                           return std::string(test.param.map == "generic" ? "Generic"
                                                                          : "Leadshine") +
                                  (test.param.line == "tcp" ? "Tcp" : "Serial");
                         });

// Contact is lost during a move: a stop is sent, and the message says that it was not confirmed.
class LostPeerTest : public ::testing::TestWithParam<std::string> {
 protected:
  void expect_fault_after(int signal) {
    const SlaveProcess slave("generic", GetParam());
    SliderConfig config = config_for(slave, GetParam(), "generic");
    config.tries = 2;
    config.response_timeout_ms = 100.0;
    SystemClock clock;
    const auto slider = open_slider(config, &clock);
    Carriage carriage(slider.get(), &clock, kLimits, kQuick);
    carriage.home();
    carriage.watch([&](WallTime /*time*/, double position_mm) {
      if (position_mm > 20.0) slave.send(signal);
    });
    expect_fault(FaultKind::kNoContact, "NOT known to have stopped: switch the drive off",
                 [&] { carriage.move_to(kLimits.require(1000.0, "test")); });
  }
};

// SIGKILL closes the link immediately; SIGSTOP leaves it open but silent.
TEST_P(LostPeerTest, KilledSlave) { expect_fault_after(SIGKILL); }
TEST_P(LostPeerTest, SilentSlave) { expect_fault_after(SIGSTOP); }

INSTANTIATE_TEST_SUITE_P(Lines, LostPeerTest, ::testing::Values("pty", "tcp"),
                         [](const auto& test) { return test.param; });

TEST(PymodbusPeerTest, MapOfAnotherDriveIsDetected) {
  const SlaveProcess slave("leadshine-pr0", "tcp");
  SystemClock clock;
  const auto slider = open_slider(config_for(slave, "tcp", "generic"), &clock);
  expect_fault(FaultKind::kWrongDevice, "is another device", [&] { slider->read_state(); });
}

}  // namespace
}  // namespace raywalk::capture
