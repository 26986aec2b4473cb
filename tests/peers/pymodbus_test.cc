// The slider driver against pymodbus, an independent Modbus implementation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <ostream>
#include <string>

#include "capture/base/device_fault.h"
#include "capture/slider/carriage.h"
#include "capture/slider/modbus_slider.h"
#include "tests/peers/slave_process.h"

namespace raywalk::capture {
namespace {

using ::testing::HasSubstr;

const SoftLimits kLimits(0.0, 1000.0);

SliderConfig config_for(const SlaveProcess& slave, const std::string& line,
                        const std::string& map) {
  SliderConfig config;
  config.connection = line == "tcp" ? SliderConnection::kTcp : SliderConnection::kRtu;
  if (line == "tcp") {
    config.host = "127.0.0.1";
    config.port = std::stoi(slave.where());
  } else {
    config.device = slave.where();
  }
  config.response_timeout_ms = 200.0;
  config.byte_timeout_ms = 100.0;
  config.tries = 10;  // the machine may be busy
  config.register_map = std::string(RAYWALK_CONFIGS "/sliders/") + map + ".yaml";
  return config;
}

MotionRules quick_rules() {
  MotionRules rules;
  rules.profile = {2000.0, 20000.0};
  rules.settle_ms = 50.0;
  return rules;
}

struct Peer {
  std::string map;
  std::string line;
};
void PrintTo(const Peer& peer, std::ostream* out) { *out << peer.map << " over " << peer.line; }

class PymodbusTest : public ::testing::TestWithParam<Peer> {
 protected:
  SlaveProcess slave{GetParam().map, GetParam().line};
  SystemClock clock;
  SliderConfig config = config_for(slave, GetParam().line, GetParam().map);
};

TEST_P(PymodbusTest, HomesMovesAndReadsBack) {
  const auto slider = open_slider(config, &clock);
  Carriage carriage(slider.get(), &clock, kLimits, quick_rules());
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
  const auto slider = open_slider(config, &clock);
  Carriage carriage(slider.get(), &clock, kLimits, quick_rules());
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
    Carriage carriage(slider.get(), &clock, kLimits, quick_rules());
    carriage.home();
    carriage.watch([&](WallTime /*time*/, double position_mm) {
      if (position_mm > 20.0) slave.send(signal);
    });
    try {
      carriage.move_to(kLimits.require(1000.0, "test"));
      ADD_FAILURE() << "settled";
    } catch (const DeviceFault& fault) {
      EXPECT_EQ(fault.kind(), FaultKind::kNoContact);
      EXPECT_THAT(fault.what(), HasSubstr("NOT known to have stopped: switch the drive off"));
    }
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
  try {
    slider->read_state();
    ADD_FAILURE() << "accepted";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.kind(), FaultKind::kWrongDevice);
    EXPECT_THAT(fault.what(), HasSubstr("is another device"));
  }
}

TEST(PymodbusPeerTest, MissingUnitIsReported) {
  const SlaveProcess slave("generic", "pty");
  SystemClock clock;
  SliderConfig config = config_for(slave, "pty", "generic");
  config.unit = 9;
  config.tries = 1;
  const auto slider = open_slider(config, &clock);
  EXPECT_THROW(slider->read_state(), DeviceFault);
}

}  // namespace
}  // namespace raywalk::capture
