#include "capture/slider/modbus_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "capture/base/test_fault.h"
#include "capture/slider/serial_line.h"
#include "capture/slider/test_modbus_peer.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using ::testing::ElementsAre;
using Line = TestModbusPeer::Line;
using Replies = std::vector<TimedReply>;

constexpr int kTimeout_ms = 60;
// Where every request is answered and openings are counted: a busy machine's pause is no timeout.
constexpr int kLongTimeout_ms = 5000;

TestModbusPeer::Script honest() {
  return [](int /*n*/, const Bytes& reply) { return Replies{{0, reply}}; };
}

SliderConfig config_for(const TestModbusPeer& peer, int timeout_ms = kTimeout_ms) {
  SliderConfig config;
  config.connection = peer.port() > 0 ? SliderConnection::kTcp : SliderConnection::kRtu;
  config.device = peer.device();
  config.host = "127.0.0.1";
  config.port = peer.port();
  config.response_timeout_ms = timeout_ms;
  config.byte_timeout_ms = timeout_ms;
  return config;
}

// Tests of both kinds of line.
class ModbusLinkTest : public ::testing::TestWithParam<Line> {
 protected:
  void use(const TestModbusPeer::Script& script, int timeout_ms = kTimeout_ms) {
    peer_.emplace(GetParam(), script);
    for (int i = 0; i < 100; ++i) peer_->set(i, static_cast<std::uint16_t>(1000 + i));
    link_.emplace(config_for(*peer_, timeout_ms), &clock_);
  }
  // Every reading has the value of its address, whatever happened to the previous reply.
  void expect_right_readings(int readings) {
    for (int i = 0; i < readings; ++i) {
      EXPECT_THAT(link_->read(RegisterKind::kHolding, i, 1), ElementsAre(1000 + i));
    }
  }

  SystemClock clock_;
  std::optional<TestModbusPeer> peer_;
  std::optional<ModbusLink> link_;
};

TEST_P(ModbusLinkTest, ReadsAndWrites) {
  use(honest());
  EXPECT_THAT(link_->read(RegisterKind::kHolding, 5, 3), ElementsAre(1005, 1006, 1007));
  EXPECT_THAT(link_->read(RegisterKind::kInput, 7, 1), ElementsAre(1007));
  EXPECT_TRUE(link_->write(20, std::array<std::uint16_t, 1>{42}));
  EXPECT_TRUE(link_->write(30, std::array<std::uint16_t, 3>{1, 2, 0xffff}));
  EXPECT_EQ(peer_->value(20), 42);
  EXPECT_EQ(peer_->value(32), 0xffff);
  EXPECT_EQ(link_->openings(), 1);
}

TEST_P(ModbusLinkTest, RequestsAreRepeatedAfterLostReplies) {
  use([](int n, const Bytes& reply) { return n % 3 == 1 ? Replies{} : Replies{{0, reply}}; });
  expect_right_readings(8);
}

// After a timeout the late reply is still pending; libmodbus alone takes it for the next reply.
TEST_P(ModbusLinkTest, LateRepliesAreNotTakenForTheNextReply) {
  use([](int n, const Bytes& reply) {
    return Replies{{n % 3 == 1 ? kTimeout_ms * 3 / 2 : 0, reply}};
  });
  expect_right_readings(8);
}

TEST_P(ModbusLinkTest, DuplicatedRepliesAreDropped) {
  use([](int n, const Bytes& reply) {
    return n % 2 == 0 ? Replies{{0, reply}, {0, reply}} : Replies{{0, reply}};
  });
  expect_right_readings(10);
}

TEST_P(ModbusLinkTest, RequestsAreRepeatedAfterTruncatedReplies) {
  use([](int n, Bytes reply) {
    if (n % 3 == 1) reply.resize(reply.size() - 3);
    return Replies{{0, reply}};
  });
  expect_right_readings(8);
}

TEST_P(ModbusLinkTest, AnswersOfAnotherShapeAreRefused) {
  use([this](int n, const Bytes& reply) {
    // Two words instead of one, in a valid frame.
    const Bytes wrong = peer_->framed({1, 3, 4, 9, 9, 9, 9}, reply);
    return n % 3 == 1 ? Replies{{0, wrong}} : Replies{{0, reply}};
  });
  expect_right_readings(6);
}

TEST_P(ModbusLinkTest, BusyDeviceIsAskedAgain) {
  const auto busy = [this](int n, const Bytes& reply) {
    return n % 3 == 1 ? Replies{{0, peer_->framed({1, 0x83, 6}, reply)}} : Replies{{0, reply}};
  };
  use(busy, kLongTimeout_ms);
  expect_right_readings(6);
  EXPECT_EQ(link_->openings(), 1);
}

TEST_P(ModbusLinkTest, RefusedRegisterMeansTheWrongDeviceOrMap) {
  use([this](int /*n*/, const Bytes& reply) {
    return Replies{{0, peer_->framed({1, 0x83, 2}, reply)}};
  });
  expect_fault(FaultKind::kWrongDevice, "refuses register 0x0007 (Illegal data address)",
               [this] { link_->read(RegisterKind::kHolding, 7, 1); });
  EXPECT_EQ(peer_->requests(), 1);
}

TEST_P(ModbusLinkTest, SilentDeviceIsReportedAfterTheLastTry) {
  use([](int /*n*/, const Bytes& /*reply*/) { return Replies{}; });
  expect_fault(FaultKind::kNoContact, "tries: 3); check the drive's power",
               [this] { link_->read(RegisterKind::kHolding, 7, 1); });
  EXPECT_EQ(peer_->requests(), 3);
}

TEST_P(ModbusLinkTest, UnansweredWriteIsNotRepeated) {
  use([](int n, const Bytes& reply) { return n == 0 ? Replies{} : Replies{{0, reply}}; });
  EXPECT_FALSE(link_->write(20, std::array<std::uint16_t, 1>{42}));
  EXPECT_EQ(peer_->requests(), 1);
  EXPECT_EQ(peer_->value(20), 42);
  EXPECT_THAT(link_->read(RegisterKind::kHolding, 20, 1), ElementsAre(42));
}

INSTANTIATE_TEST_SUITE_P(Lines, ModbusLinkTest, ::testing::Values(Line::kSerial, Line::kTcp),
                         [](const auto& test) {
                           return test.param == Line::kSerial ? "Serial" : "Tcp";
                         });

TEST(ModbusSerialLinkTest, RequestsAreRepeatedAfterDamagedReplies) {
  TestModbusPeer peer(Line::kSerial, [](int n, Bytes reply) {
    if (n % 3 == 1) reply[4] ^= 0x10;
    return Replies{{0, reply}};
  });
  for (int i = 0; i < 10; ++i) peer.set(i, static_cast<std::uint16_t>(i));
  SystemClock clock;
  ModbusLink link(config_for(peer), &clock);
  for (int i = 0; i < 8; ++i) {
    EXPECT_THAT(link.read(RegisterKind::kHolding, i, 1), ElementsAre(i));
  }
  EXPECT_EQ(link.openings(), 1);
}

TEST(ModbusSerialLinkTest, LineThatIsNeverSilentIsReported) {
  TestModbusPeer peer(Line::kSerial, [](int /*n*/, const Bytes& /*reply*/) {
    Replies chatter;
    for (int ms = 0; ms < 3000; ++ms) chatter.push_back({ms, {0x55}});
    return chatter;
  });
  SystemClock clock;
  SliderConfig config = config_for(peer);
  config.tries = 2;
  ModbusLink link(config, &clock);
  EXPECT_THROW(link.read(RegisterKind::kHolding, 0, 1), DeviceFault);
}

TEST(ModbusSerialLinkTest, HungUpLineEndsInAFaultThatNamesThePort) {
  TestModbusPeer peer(Line::kSerial, honest());
  SystemClock clock;
  ModbusLink link(config_for(peer), &clock);
  link.read(RegisterKind::kHolding, 0, 1);
  peer.hang_up();
  expect_fault(FaultKind::kNoContact, peer.device(), [&] {
    for (int i = 0; i < 1000; ++i) link.read(RegisterKind::kHolding, 0, 1);
  });
}

TEST(ModbusSerialLinkTest, ReconnectsToARepluggedAdapterOfTheSameName) {
  const TestDirectory directory;
  const auto by_id = directory / "usb-adapter";
  std::optional<TestModbusPeer> peer(std::in_place, Line::kSerial, honest());
  std::filesystem::create_symlink(peer->device(), by_id);
  SystemClock clock;
  SliderConfig config = config_for(*peer, kLongTimeout_ms);
  config.device = by_id;
  ModbusLink link(config, &clock);
  link.read(RegisterKind::kHolding, 0, 1);

  TestModbusPeer returned(Line::kSerial, honest());
  returned.set(0, 77);
  std::filesystem::remove(by_id);
  std::filesystem::create_symlink(returned.device(), by_id);
  peer.reset();
  EXPECT_THAT(link.read(RegisterKind::kHolding, 0, 1), ElementsAre(77));
  EXPECT_EQ(link.openings(), 2);
}

TEST(ModbusSerialLinkTest, SecondProgramOnThePortIsRefused) {
  TestModbusPeer peer(Line::kSerial, honest());
  SystemClock clock;
  ModbusLink first(config_for(peer), &clock);
  first.read(RegisterKind::kHolding, 0, 1);
  SliderConfig config = config_for(peer);
  config.tries = 1;
  ModbusLink second(config, &clock);
  expect_fault(FaultKind::kNoContact, peer.device() + " is in use by another program",
               [&] { second.read(RegisterKind::kHolding, 0, 1); });
  EXPECT_THAT(first.read(RegisterKind::kHolding, 0, 1), ElementsAre(0));
}

TEST(ModbusSerialLinkTest, PortIsFreeAgainAfterUse) {
  TestModbusPeer peer(Line::kSerial, honest());
  { const PortLock lock(peer.device()); }
  EXPECT_NO_THROW(PortLock(peer.device()));
}

TEST(ModbusSerialLinkTest, PortsThatCannotBeOpenedSayWhatToDo) {
  const TestDirectory directory;
  expect_fault(FaultKind::kNoContact, "does not exist; plug in the adapter",
               [&] { PortLock(directory / "ttyUSB0"); });
  write_file_atomically(directory / "file", "x");
  expect_fault(FaultKind::kNoContact, "is not a serial port",
               [&] { PortLock(directory / "file"); });
}

TEST(ModbusSerialLinkTest, Rs485OnAPortWithoutItIsAnError) {
  TestModbusPeer peer(Line::kSerial, honest());
  SystemClock clock;
  SliderConfig config = config_for(peer);
  config.rs485 = true;
  config.tries = 1;
  ModbusLink link(config, &clock);
  expect_fault(FaultKind::kNoContact, "leave slider.rs485 out",
               [&] { link.read(RegisterKind::kHolding, 0, 1); });
}

TEST(ModbusTcpLinkTest, ClosedConnectionIsOpenedAgainBeforeAWrite) {
  TestModbusPeer peer(Line::kTcp, honest());
  SystemClock clock;
  ModbusLink link(config_for(peer, kLongTimeout_ms), &clock);
  link.read(RegisterKind::kHolding, 0, 1);
  peer.hang_up();
  EXPECT_TRUE(link.write(1, std::array<std::uint16_t, 1>{5}));
  EXPECT_EQ(link.openings(), 2);
  EXPECT_EQ(peer.connections(), 2);
}

TEST(ModbusTcpLinkTest, NobodyListeningIsReported) {
  SystemClock clock;
  SliderConfig config;
  config.connection = SliderConnection::kTcp;
  config.host = "127.0.0.1";
  config.port = 1;
  config.tries = 1;
  ModbusLink link(config, &clock);
  expect_fault(FaultKind::kNoContact, "cannot connect to 127.0.0.1:1 (Connection refused)",
               [&] { link.read(RegisterKind::kHolding, 0, 1); });
}

TEST(ModbusLinkSettingsTest, ImpossibleSettingsAreRefused) {
  SystemClock clock;
  SliderConfig good;
  good.device = "/dev/ttyUSB0";
  EXPECT_NO_THROW(ModbusLink(good, &clock));
  const auto refused = [&](auto change) {
    SliderConfig config = good;
    change(&config);
    EXPECT_THROW(ModbusLink(config, &clock), UsageError);
  };
  refused([](SliderConfig* config) { config->baud = 250000; });
  refused([](SliderConfig* config) { config->stop_bits = 3; });
  refused([](SliderConfig* config) { config->unit = 0; });
  refused([](SliderConfig* config) { config->unit = 255; });
  refused([](SliderConfig* config) { config->device = ""; });
  refused([](SliderConfig* config) { config->connection = SliderConnection::kTcp; });
  good.connection = SliderConnection::kTcp;
  good.host = "drive.local";
  good.unit = 255;
  EXPECT_NO_THROW(ModbusLink(good, &clock));
}

TEST(QuietLineTest, FrameGapIsThreeAndAHalfCharacters) {
  EXPECT_NEAR(ms_from_duration(frame_gap(9600)), 38.5 / 9.6, 1e-3);
  EXPECT_NEAR(ms_from_duration(frame_gap(115200)), 1.75, 1e-9);
}

}  // namespace
}  // namespace raywalk::capture
