#include "capture/slider/modbus_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "capture/base/test_fault.h"
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

// A peer and a link to it, whose registers 0 to 99 hold 1000 plus their address.
class LinkRig {
 public:
  using Script = std::function<Replies(const TestModbusPeer& peer, int n, const Bytes& reply)>;

  static Replies honest(const TestModbusPeer& /*peer*/, int /*n*/, const Bytes& reply) {
    return {{0, reply}};
  }
  explicit LinkRig(Line line, const Script& script = honest, int timeout_ms = kTimeout_ms)
      : peer(line, [this, script](int n, const Bytes& reply) { return script(peer, n, reply); }) {
    for (int i = 0; i < 100; ++i) peer.set(i, static_cast<std::uint16_t>(1000 + i));
    config.connection = line == Line::kTcp ? SliderConnection::kTcp : SliderConnection::kRtu;
    config.device = peer.device();
    config.host = "127.0.0.1";
    config.port = peer.port();
    config.response_timeout_ms = timeout_ms;
    config.byte_timeout_ms = timeout_ms;
    link.emplace(config, &clock);
  }

  std::uint16_t read(int address) { return link->read(RegisterKind::kHolding, address, 1)[0]; }
  void expect_fault(FaultKind kind, const std::string& words) {
    raywalk::capture::expect_fault(kind, words, [this] { read(7); });
  }

  SystemClock clock;
  TestModbusPeer peer;
  SliderConfig config;
  std::optional<ModbusLink> link;
};

class ModbusLinkTest : public ::testing::TestWithParam<Line> {};

INSTANTIATE_TEST_SUITE_P(Lines, ModbusLinkTest, ::testing::Values(Line::kSerial, Line::kTcp),
                         [](const auto& test) {
                           return test.param == Line::kSerial ? "Serial" : "Tcp";
                         });

TEST_P(ModbusLinkTest, ReadsAndWrites) {
  LinkRig rig(GetParam(), LinkRig::honest, kLongTimeout_ms);
  EXPECT_THAT(rig.link->read(RegisterKind::kHolding, 5, 3), ElementsAre(1005, 1006, 1007));
  EXPECT_THAT(rig.link->read(RegisterKind::kInput, 7, 1), ElementsAre(1007));
  EXPECT_TRUE(rig.link->write(20, std::array<std::uint16_t, 1>{42}));
  EXPECT_TRUE(rig.link->write(30, std::array<std::uint16_t, 3>{1, 2, 0xffff}));
  EXPECT_EQ(rig.peer.value(20), 42);
  EXPECT_EQ(rig.peer.value(32), 0xffff);
  EXPECT_EQ(rig.link->openings(), 1);
}

// Every reading has the value of its address, whatever happened to a reply before it. After a
// timeout a late reply is still pending, which libmodbus alone takes for the next one.
TEST_P(ModbusLinkTest, ReadingsAreRightAfterAnyFaultOfAReply) {
  const auto every_third = [](const std::function<Replies(const TestModbusPeer&, Bytes)>& fault) {
    return [fault](const TestModbusPeer& peer, int n, const Bytes& reply) {
      return n % 3 == 1 ? fault(peer, reply) : Replies{{0, reply}};
    };
  };
  struct Case {
    const char* fault;
    std::function<Replies(const TestModbusPeer&, Bytes)> replies;
    int timeout_ms = kTimeout_ms;
  };
  const auto framed = [](const Bytes& body) {
    return [body](const TestModbusPeer& peer, const Bytes& reply) {
      return Replies{{0, peer.framed(body, reply)}};
    };
  };
  std::vector<Case> cases{
      {"lost", [](auto&, auto&&) { return Replies{}; }},
      {"late",
       [](auto&, auto&& reply) {
         return Replies{{kTimeout_ms * 3 / 2, reply}};
       }},
      {"doubled",
       [](auto&, auto&& reply) {
         return Replies{{0, reply}, {0, reply}};
       }},
      {"truncated",
       [](auto&, Bytes reply) {
         reply.resize(reply.size() - 3);
         return Replies{{0, reply}};
       }},
      {"of two words instead of one, in a valid frame", framed({1, 3, 4, 9, 9, 9, 9})},
      {"busy", framed({1, 0x83, 6}), kLongTimeout_ms}};
  if (GetParam() == Line::kSerial) {
    cases.push_back({"damaged", [](auto&, Bytes reply) {
                       reply[4] ^= 0x10;
                       return Replies{{0, reply}};
                     }});
  }
  for (const Case& each : cases) {
    SCOPED_TRACE(each.fault);
    LinkRig rig(GetParam(), every_third(each.replies), each.timeout_ms);
    for (int i = 0; i < 8; ++i) EXPECT_EQ(rig.read(i), 1000 + i);
    EXPECT_TRUE(each.timeout_ms == kTimeout_ms || rig.link->openings() == 1);
  }
}

TEST_P(ModbusLinkTest, RefusalsNameTheRegisterOrTheFunction) {
  for (const auto& [exception, words] :
       {std::pair<std::uint8_t, const char*>{2, "refuses register 0x0007 (Illegal data address)"},
        {1,
         "does not know function 3 of Modbus (Illegal function); set input_registers to true"}}) {
    LinkRig rig(
        GetParam(),
        [exception = exception](const TestModbusPeer& peer, int, const Bytes& reply) {
          return Replies{{0, peer.framed({1, 0x83, exception}, reply)}};
        },
        kLongTimeout_ms);
    rig.expect_fault(FaultKind::kWrongDevice, words);
    EXPECT_EQ(rig.peer.requests(), 1);
  }
}

TEST_P(ModbusLinkTest, SilentDeviceIsReportedAfterTheLastTry) {
  LinkRig rig(GetParam(), [](auto&, int, auto&) { return Replies{}; });
  rig.expect_fault(FaultKind::kNoContact, "tries: 3); check the drive's power");
  EXPECT_GE(rig.peer.requests(), 3);
}

TEST_P(ModbusLinkTest, UnansweredWriteIsNotRepeated) {
  LinkRig rig(GetParam(), [](auto&, int n, const Bytes& reply) {
    return n == 0 ? Replies{} : Replies{{0, reply}};
  });
  EXPECT_FALSE(rig.link->write(20, std::array<std::uint16_t, 1>{42}));
  EXPECT_EQ(rig.peer.requests(), 1);
  EXPECT_EQ(rig.peer.value(20), 42);
  EXPECT_EQ(rig.read(20), 42);
}

// As a two-wire adapter whose receiver stays on while it sends.
TEST(ModbusSerialLinkTest, AdapterThatEchoesIsNamed) {
  for (const bool answers : {true, false}) {
    LinkRig rig(Line::kSerial, [&](const TestModbusPeer& peer, int, const Bytes& reply) {
      return answers ? Replies{{0, peer.request()}, {0, reply}} : Replies{{0, peer.request()}};
    });
    rig.expect_fault(FaultKind::kNoContact, "the RS-485 adapter echoes");
  }
}

TEST(ModbusSerialLinkTest, LineThatIsNeverSilentIsReported) {
  LinkRig rig(Line::kSerial, [](auto&, int, auto&) {
    Replies chatter;
    for (int ms = 0; ms < 3000; ++ms) chatter.push_back({ms, {0x55}});
    return chatter;
  });
  EXPECT_THROW(rig.read(0), DeviceFault);
}

TEST(ModbusSerialLinkTest, HungUpLineEndsInAFaultThatNamesThePort) {
  LinkRig rig(Line::kSerial);
  rig.read(0);
  rig.peer.hang_up();
  expect_fault(FaultKind::kNoContact, rig.peer.device(), [&] {
    for (int i = 0; i < 1000; ++i) rig.read(0);
  });
}

TEST(ModbusSerialLinkTest, ReconnectsToARepluggedAdapterOfTheSameName) {
  const TestDirectory directory;
  const auto by_id = directory / "usb-adapter";
  std::optional<LinkRig> rig(std::in_place, Line::kSerial, LinkRig::honest, kLongTimeout_ms);
  std::filesystem::create_symlink(rig->peer.device(), by_id);
  SliderConfig config = rig->config;
  config.device = by_id;
  SystemClock clock;
  ModbusLink link(config, &clock);
  rig->link.reset();
  link.read(RegisterKind::kHolding, 0, 1);

  LinkRig returned(Line::kSerial);
  returned.peer.set(0, 77);
  std::filesystem::remove(by_id);
  std::filesystem::create_symlink(returned.peer.device(), by_id);
  rig.reset();
  EXPECT_THAT(link.read(RegisterKind::kHolding, 0, 1), ElementsAre(77));
  EXPECT_EQ(link.openings(), 2);
}

TEST(ModbusSerialLinkTest, SecondProgramOnThePortIsRefused) {
  LinkRig rig(Line::kSerial);
  rig.read(0);
  rig.config.tries = 1;
  std::optional<ModbusLink> second(std::in_place, rig.config, &rig.clock);
  const auto use_second = [&] { second->read(RegisterKind::kHolding, 0, 1); };
  expect_fault(FaultKind::kNoContact, rig.peer.device() + " is in use by another program",
               use_second);
  EXPECT_EQ(rig.read(0), 1000);
  rig.link.reset();
  EXPECT_NO_THROW(use_second()) << "the port is free again";
}

TEST(ModbusSerialLinkTest, PortsThatCannotBeUsedSayWhatToDo) {
  const TestDirectory directory;
  write_file_atomically(directory / "file", "x");
  LinkRig rig(Line::kSerial);
  rig.config.tries = 1;
  const auto expect_words = [&](const std::string& words) {
    rig.link.emplace(rig.config, &rig.clock);
    rig.expect_fault(FaultKind::kNoContact, words);
  };
  rig.config.rs485 = true;
  expect_words("leave slider.rs485 out");
  rig.config.device = directory / "ttyUSB0";
  expect_words("does not exist; plug in the adapter");
  rig.config.device = directory / "file";
  expect_words("is not a serial port");
}

TEST(ModbusTcpLinkTest, ClosedConnectionIsOpenedAgainBeforeAWrite) {
  LinkRig rig(Line::kTcp, LinkRig::honest, kLongTimeout_ms);
  rig.read(0);
  rig.peer.hang_up();
  EXPECT_TRUE(rig.link->write(1, std::array<std::uint16_t, 1>{5}));
  EXPECT_EQ(rig.link->openings(), 2);
  EXPECT_EQ(rig.peer.connections(), 2);
}

TEST(ModbusTcpLinkTest, NobodyListeningIsReported) {
  LinkRig rig(Line::kTcp);
  rig.config.port = 1;
  rig.config.tries = 1;
  rig.link.emplace(rig.config, &rig.clock);
  rig.expect_fault(FaultKind::kNoContact, "cannot connect to 127.0.0.1:1 (Connection refused)");
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

}  // namespace
}  // namespace raywalk::capture
