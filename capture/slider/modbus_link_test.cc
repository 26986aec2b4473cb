#include "capture/slider/modbus_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "simulator/rig/drive_server.h"

namespace raywalk::capture {
namespace {

using ::testing::ElementsAre;
using Bytes = std::vector<std::uint8_t>;
using Replies = std::vector<simulator::TimedBytes>;
using Script = std::function<Replies(int n, const Bytes& request, const Bytes& reply)>;

constexpr double kTimeout_ms = 60.0;
// Where every request is answered and openings are counted: a busy machine's pause is no timeout.
constexpr double kLongTimeout_ms = 5000.0;

// The simulated drive with its own registers far away, and a link to it. Registers 0 to 99 hold
// 1000 plus their address. The script sends what it likes instead of the reply to request n, from
// 0.
class LinkRig {
 public:
  explicit LinkRig(SliderConnection line, const Script& script = {},
                   double timeout_ms = kTimeout_ms)
      : server_({.serial_link = directory_ / "slider",
                 .tcp_port = 0,
                 .line = [this](const Bytes& request,
                                const Bytes& reply) { return sent(request, reply); }},
                far_away(), &drive_, &faults) {
    config.connection = line;
    config.device = directory_ / "slider";
    config.host = "127.0.0.1";
    config.port = server_.tcp_port();
    config.response_timeout_ms = config.byte_timeout_ms = kLongTimeout_ms;
    std::array<std::uint16_t, 100> values{};
    std::iota(values.begin(), values.end(), std::uint16_t{1000});
    EXPECT_TRUE(ModbusLink(config, &clock).write(0, values));
    config.response_timeout_ms = config.byte_timeout_ms = timeout_ms;
    link.emplace(config, &clock);
    before_ = static_cast<int>(faults.exchanges());
    script_ = script;
  }

  std::uint16_t read(int address) { return link->read(RegisterKind::kHolding, address, 1)[0]; }
  bool write(int address, std::uint16_t value) {
    return link->write(address, std::array<std::uint16_t, 1>{value});
  }
  int requests() const { return static_cast<int>(faults.exchanges()) - before_; }
  void expect_fault(FaultKind kind, const std::string& words) {
    raywalk::capture::expect_fault(kind, words, [this] { read(7); });
  }
  // With another configuration and a single try.
  void expect_no_contact(const std::string& words) {
    config.tries = 1;
    link.emplace(config, &clock);
    expect_fault(FaultKind::kNoContact, words);
  }

 private:
  const TestDirectory directory_;
  ManualClock drive_clock_;

 public:
  SystemClock clock;
  simulator::Faults faults{&drive_clock_};
  SliderConfig config;
  std::optional<ModbusLink> link;

 private:
  static RegisterMap far_away() {
    RegisterMap map;
    map.steps_per_mm = 1.0;
    map.status_address = 30000;
    map.position_address = 30001;
    return map;
  }
  Replies sent(const Bytes& request, const Bytes& reply) {
    return script_ ? script_(requests() - 1, request, reply) : Replies{{0.0, reply}};
  }

  Script script_;
  int before_ = 0;
  simulator::SimulatedDrive drive_{{}, &drive_clock_, &faults};
  simulator::DriveServer server_;
};

// The frame of a body of unit, function and data, on the line of a request.
Bytes framed(SliderConnection line, const Bytes& request, Bytes body) {
  if (line == SliderConnection::kTcp) {
    Bytes frame{request[0], request[1], 0, 0, 0, static_cast<std::uint8_t>(body.size())};
    frame.insert(frame.end(), body.begin(), body.end());
    return frame;
  }
  // CRC-16 with the polynomial 0xA001, from 0xFFFF (Modbus over serial line 1.02, 6.2.2).
  unsigned sum = 0xffff;
  for (const std::uint8_t byte : body) {
    sum ^= byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1) != 0 ? (sum >> 1) ^ 0xa001 : sum >> 1;
  }
  body.push_back(static_cast<std::uint8_t>(sum & 0xff));
  body.push_back(static_cast<std::uint8_t>(sum >> 8));
  return body;
}

class ModbusLinkTest : public ::testing::TestWithParam<SliderConnection> {
 protected:
  Script always(const Bytes& body) {
    return [line = GetParam(), body](int, const Bytes& request, const Bytes&) {
      return Replies{{0.0, framed(line, request, body)}};
    };
  }
};

INSTANTIATE_TEST_SUITE_P(Lines, ModbusLinkTest, ::testing::ValuesIn(kSliderConnections),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(ModbusLinkTest, ReadsAndWrites) {
  LinkRig rig(GetParam(), {}, kLongTimeout_ms);
  EXPECT_THAT(rig.link->read(RegisterKind::kHolding, 5, 3), ElementsAre(1005, 1006, 1007));
  EXPECT_TRUE(rig.write(20, 42));
  EXPECT_TRUE(rig.link->write(30, std::array<std::uint16_t, 3>{1, 2, 0xffff}));
  EXPECT_EQ(rig.read(20), 42);
  EXPECT_EQ(rig.read(32), 0xffff);
  EXPECT_EQ(rig.link->openings(), 1);
}

// Every reading has the value of its address, whatever happened to a reply before it. After a
// timeout a late reply is still pending, which libmodbus alone takes for the next one.
TEST_P(ModbusLinkTest, ReadingsAreRightAfterAnyFaultOfAReply) {
  struct Case {
    const char* fault;
    std::function<Replies(const Bytes& request, Bytes reply)> replies;
    double timeout_ms = kTimeout_ms;
  };
  const auto frame_of = [this](const Bytes& body) {
    return [script = always(body)](const Bytes& request, const Bytes& reply) {
      return script(0, request, reply);
    };
  };
  std::vector<Case> cases{
      {"lost", [](auto&, auto) { return Replies{}; }},
      {"late",
       [](auto&, auto reply) {
         return Replies{{kTimeout_ms * 1.5, reply}};
       }},
      {"doubled",
       [](auto&, auto reply) {
         return Replies{{0.0, reply}, {0.0, reply}};
       }},
      {"truncated",
       [](auto&, Bytes reply) {
         reply.resize(reply.size() - 3);
         return Replies{{0.0, reply}};
       }},
      {"of two words instead of one, in a valid frame", frame_of({1, 3, 4, 9, 9, 9, 9})},
      {"busy", frame_of({1, 0x83, 6}), kLongTimeout_ms}};
  if (GetParam() == SliderConnection::kRtu) {
    cases.push_back({"damaged", [](auto&, Bytes reply) {
                       reply[4] ^= 0x10;
                       return Replies{{0.0, reply}};
                     }});
  }
  for (const Case& each : cases) {
    SCOPED_TRACE(each.fault);
    const auto every_third = [&](int n, const Bytes& request, const Bytes& reply) {
      return n % 3 == 1 ? each.replies(request, reply) : Replies{{0.0, reply}};
    };
    LinkRig rig(GetParam(), every_third, each.timeout_ms);
    for (int i = 0; i < 8; ++i) EXPECT_EQ(rig.read(i), 1000 + i);
    EXPECT_TRUE(each.timeout_ms == kTimeout_ms || rig.link->openings() == 1);
  }
}

TEST_P(ModbusLinkTest, RefusalsNameTheRegisterOrTheFunction) {
  for (const auto& [exception, words] :
       {std::pair<std::uint8_t, const char*>{2, "refuses register 0x0007 (Illegal data address)"},
        {1,
         "does not know function 3 of Modbus (Illegal function); set input_registers to true"}}) {
    LinkRig rig(GetParam(), always({1, 0x83, exception}), kLongTimeout_ms);
    rig.expect_fault(FaultKind::kWrongDevice, words);
    EXPECT_EQ(rig.requests(), 1);
  }
}

TEST_P(ModbusLinkTest, SilentDeviceIsReportedAfterTheLastTry) {
  LinkRig rig(GetParam(), [](int, auto&, auto&) { return Replies{}; });
  rig.expect_fault(FaultKind::kNoContact, "tries: 3); check the drive's power");
  EXPECT_GE(rig.requests(), 3);
}

TEST_P(ModbusLinkTest, UnansweredWriteIsNotRepeated) {
  LinkRig rig(GetParam(), [](int n, auto&, const Bytes& reply) {
    return n == 0 ? Replies{} : Replies{{0.0, reply}};
  });
  EXPECT_FALSE(rig.write(20, 42));
  EXPECT_EQ(rig.requests(), 1);
  EXPECT_EQ(rig.read(20), 42);
}

TEST_P(ModbusLinkTest, ClosedLineIsOpenedAgainOrReportedByItsName) {
  LinkRig rig(GetParam(), {}, kLongTimeout_ms);
  rig.read(0);
  rig.faults.add({.kind = simulator::RigFault::kCut});
  const std::string name = GetParam() == SliderConnection::kTcp ? "127.0.0.1" : rig.config.device;
  rig.config.response_timeout_ms = kTimeout_ms;
  expect_fault(FaultKind::kNoContact, name, [&] {
    for (int i = 0; i < 1000; ++i) rig.read(0);
  });
  rig.faults.clear();
  bool is_back = false;
  for (int attempt = 0; attempt < 10 && !is_back; ++attempt) {
    try {
      is_back = rig.write(1, 5);
    } catch (const DeviceFault&) {  // the server opens its lines again within milliseconds
    }
  }
  EXPECT_EQ(rig.read(1), 5);
  EXPECT_GE(rig.link->openings(), 2);
}

// As a two-wire adapter whose receiver stays on while it sends.
TEST(ModbusSerialLinkTest, AdapterThatEchoesIsNamed) {
  for (const bool answers : {true, false}) {
    LinkRig rig(SliderConnection::kRtu, [&](int, const Bytes& request, const Bytes& reply) {
      return answers ? Replies{{0.0, request}, {0.0, reply}} : Replies{{0.0, request}};
    });
    rig.expect_fault(FaultKind::kNoContact, "the RS-485 adapter echoes");
  }
}

TEST(ModbusSerialLinkTest, LineThatIsNeverSilentIsReported) {
  LinkRig rig(SliderConnection::kRtu, [](int, auto&, auto&) {
    Replies chatter;
    for (int ms = 0; ms < 3000; ++ms) chatter.push_back({1.0 * ms, {0x55}});
    return chatter;
  });
  EXPECT_THROW(rig.read(0), DeviceFault);
}

TEST(ModbusSerialLinkTest, SecondProgramOnThePortIsRefused) {
  LinkRig rig(SliderConnection::kRtu);
  rig.read(0);
  rig.config.tries = 1;
  std::optional<ModbusLink> second(std::in_place, rig.config, &rig.clock);
  const auto use_second = [&] { second->read(RegisterKind::kHolding, 0, 1); };
  expect_fault(FaultKind::kNoContact, rig.config.device + " is in use by another program",
               use_second);
  EXPECT_EQ(rig.read(0), 1000);
  rig.link.reset();
  EXPECT_NO_THROW(use_second()) << "the port is free again";
}

TEST(ModbusLinkSettingsTest, LinesThatCannotBeUsedSayWhatToDo) {
  const TestDirectory directory;
  write_file_atomically(directory / "file", "x");
  LinkRig rig(SliderConnection::kRtu);
  rig.config.rs485 = true;
  rig.expect_no_contact("leave slider.rs485 out");
  rig.config.device = directory / "ttyUSB0";
  rig.expect_no_contact("does not exist; plug in the adapter");
  rig.config.device = directory / "file";
  rig.expect_no_contact("is not a serial port");
  rig.config.connection = SliderConnection::kTcp;
  rig.config.port = 1;
  rig.expect_no_contact("cannot connect to 127.0.0.1:1 (Connection refused)");
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
