#include "capture/slider/modbus_slider.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/base/test_fault.h"
#include "capture/slider/modbus_link.h"
#include "capture/slider/register_map.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/shipped_configs.h"
#include "core/files/test_support.h"
#include "core/files/test_yaml_keys.h"
#include "simulator/rig/drive_server.h"

namespace raywalk::capture {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Replies = std::vector<simulator::TimedBytes>;
using Script = std::function<Replies(int n, const Bytes& request, const Bytes& reply)>;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using enum WordMeaning;

using Write = std::pair<int, std::vector<std::uint16_t>>;  // the address and the words

// Registers in memory that count requests.
class FakeRegisters final : public RegisterLink {
 public:
  std::string description() const override { return "unit 1 in memory"; }
  int openings() const override { return openings_count; }
  std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) override {
    if (openings_count == 0) openings_count = 1;
    last_kind = kind;
    reads.emplace_back(address, count);
    std::vector<std::uint16_t> words;
    for (int i = 0; i < count; ++i) words.push_back(values[address + i]);
    if (nonsense > 0 && address == 0) {
      --nonsense;
      for (auto& word : words) word = 0xffff;
    }
    return words;
  }
  bool write(int address, std::span<const std::uint16_t> words) override {
    writes.emplace_back(address, std::vector<std::uint16_t>(words.begin(), words.end()));
    const bool answered = unanswered.count(static_cast<int>(writes.size()) - 1) == 0;
    if (!answered && take_unanswered) values[0] = 0x0008;
    return answered;
  }

  int openings_count = 0;
  int nonsense = 0;              // readings of the status as all ones
  std::set<int> unanswered;      // numbers of writes
  bool take_unanswered = false;  // the drive executes them nevertheless
  RegisterKind last_kind = RegisterKind::kHolding;
  std::map<int, std::uint16_t> values;
  std::vector<std::pair<int, int>> reads;
  std::vector<Write> writes;
};

// Moves write the position, or these words.
RegisterMap simple_map(double steps_per_mm = 10.0,
                       std::vector<BlockWord> move = {{kPositionHigh}, {kPositionLow}}) {
  RegisterMap map;
  map.name = "test";
  map.steps_per_mm = steps_per_mm;
  map.status_address = 0;
  map.position_address = 1;
  map.speed_per_mm_s = 1.0;
  map.acceleration_per_mm_s2 = 1.0;
  map.move = {16, std::move(move)};
  map.home = {32, {{kConstant, 2}}};
  map.stop = {32, {{kConstant, 3}}};
  map.alarm = StatusBit{0, false};
  map.moving = StatusBit{3, false};
  return map;
}

class ModbusSliderTest : public ::testing::Test {
 protected:
  ModbusSliderTest() { use(map); }
  void use(const RegisterMap& changed) {
    auto link = std::make_unique<FakeRegisters>();
    registers = link.get();
    drive.emplace(std::move(link), changed, 3);
  }
  void move_to(double mm) {
    drive->start_move(SoftLimits(-1e9, 1e9).require(mm, "test"), MotionProfile{});
  }
  void expect_wrong_device(const std::string& words) {
    expect_fault(FaultKind::kWrongDevice, words, [this] { drive->read_state(); });
  }

  RegisterMap map = simple_map();
  FakeRegisters* registers = nullptr;
  std::optional<ModbusSlider> drive;
};

TEST_F(ModbusSliderTest, ReadsAdjacentRegistersInOneRequest) {
  registers->values = {{0, 0x0008}, {1, 0xffff}, {2, 0xff9c}};
  const SliderState state = drive->read_state();
  EXPECT_EQ(state.position_mm, -10.0);
  EXPECT_EQ(state.moving, true);
  EXPECT_EQ(state.homed, std::nullopt);
  EXPECT_FALSE(state.alarm);
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(0, 3)));
}

TEST_F(ModbusSliderTest, ReadsAcrossAGapOnlyIfTheMapAllows) {
  map.status_address = 9;
  map.input_registers = true;
  use(map);
  drive->read_state();
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(9, 1), std::pair(1, 2)));
  EXPECT_EQ(registers->last_kind, RegisterKind::kInput);
  map.one_read = true;
  use(map);
  registers->values = {{9, 0x0008}, {2, 50}};
  const SliderState state = drive->read_state();
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(1, 9)));
  EXPECT_EQ(state.position_mm, 5.0);
  EXPECT_EQ(state.moving, true);
}

TEST_F(ModbusSliderTest, AlarmCodeIsReadDuringAnAlarmOnly) {
  map.alarm_address = 40;
  map.alarm.active_low = true;
  use(map);
  registers->values = {{0, 1}, {40, 0x00e0}};
  EXPECT_EQ(drive->read_state().alarm_code, 0);
  EXPECT_EQ(registers->reads.size(), 1u);
  registers->values[0] = 0;
  EXPECT_EQ(drive->read_state().alarm_code, 0xe0);
}

TEST_F(ModbusSliderTest, AnotherDeviceIsNoticedAtEveryOpening) {
  map.identity_address = 50;
  map.identity_value = 0x1234;
  use(map);
  registers->values[50] = 0x1234;
  EXPECT_NO_THROW(drive->read_state());
  registers->values[50] = 0x4321;
  EXPECT_NO_THROW(drive->read_state());
  registers->openings_count = 2;
  expect_wrong_device("register 0x0032 holds 0x4321, not 0x1234");
}

TEST_F(ModbusSliderTest, ImpossibleReadingsTwiceInARowAreAWrongDevice) {
  registers->nonsense = 1;
  EXPECT_NO_THROW(drive->read_state());
  registers->nonsense = 2;
  expect_wrong_device("(status 0xffff, position -0 mm); check the register map");
  // In the wrong order of the position's words.
  registers->values = {{1, 1234}, {2, 0}};
  expect_wrong_device("words are 123.400 mm: if the carriage is there, set low_word_first to true");
  registers->values = {{1, 0xff00}, {2, 0xffff}};
  expect_wrong_device("words are -25.600 mm");
  registers->values = {{1, 0x7fff}, {2, 0x7ffe}};
  expect_wrong_device("check the register map against");
}

TEST_F(ModbusSliderTest, CommandsWriteTheirWords) {
  map.start = RegisterWrite{20, {{kConstant, 1}}};
  use(map);
  move_to(7000.0);  // 70000 steps
  drive->start_homing();
  EXPECT_THAT(registers->writes, ElementsAre(Write{16, {1, 4464}}, Write{20, {1}}, Write{32, {2}}));
  EXPECT_THROW(move_to(3e8), UsageError) << "beyond the registers";
  EXPECT_EQ(registers->writes.size(), 3u);
  EXPECT_THAT(drive->description(), HasSubstr("test, unit 1 in memory"));
}

TEST_F(ModbusSliderTest, UnansweredMoveIsRepeatedOnlyIfNotExecuted) {
  registers->unanswered = {0};
  move_to(100.0);
  EXPECT_EQ(registers->writes.size(), 2u);
  EXPECT_EQ(registers->reads.size(), 1u);
  use(map);
  registers->unanswered = {0};
  registers->take_unanswered = true;
  move_to(100.0);
  EXPECT_EQ(registers->writes.size(), 1u);
}

TEST_F(ModbusSliderTest, MoveThatIsNeverAnsweredIsLostContact) {
  registers->unanswered = {0, 1, 2, 3};
  expect_fault(FaultKind::kNoContact, "does not answer a write to register 0x0010 (tries: 3)",
               [&] { move_to(100.0); });
  EXPECT_EQ(registers->writes.size(), 3u);
}

TEST_F(ModbusSliderTest, StopIsRepeatedAtOnceWithoutReading) {
  registers->unanswered = {0, 1};
  drive->stop();
  EXPECT_THAT(registers->writes, ElementsAre(Write{32, {3}}, Write{32, {3}}, Write{32, {3}}));
  EXPECT_TRUE(registers->reads.empty());
}

// --- Register maps -------------------------------------------------------------------------------

std::filesystem::path shipped(const std::string& name) {
  return std::filesystem::path(RAYWALK_CONFIGS "/sliders") / name;
}

// The least that a map must have.
const char* const kMinimal =
    "name: small\nsteps_per_mm: 80\nposition_address: 10\nstatus_address: 12\nspeed_per_mm_s: 2\n"
    "acceleration_per_mm_s2: 1\nmove: {address: 0x20, words: [position_low, position_high]}\n"
    "home: {address: 1, words: [1]}\nstop: {address: 1, words: [2]}\n"
    "status: {alarm: {bit: 15, active_low: true}}\n";

RegisterMap parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "map.yaml", yaml);
  return read_register_map(directory / "map.yaml");
}

// The minimal map with `from` replaced by `to`.
std::string with(const std::string& from, const std::string& to) {
  std::string yaml = kMinimal;
  const auto at = yaml.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return yaml.replace(at, from.size(), to);
}

TEST(RegisterMapTest, GenericMapDocumentsEveryKeyAndNoOther) {
  EXPECT_EQ(keys_of_yaml(shipped("generic.yaml")), register_map_keys());
}

TEST(RegisterMapTest, ShippedMapsCanBeRead) {
  for (const std::string& name : shipped_config_names(ConfigKind::kSlider)) {
    EXPECT_FALSE(read_register_map(shipped(name + ".yaml")).name.empty());
  }
  EXPECT_EQ(read_register_map(shipped("generic.yaml")).identity_value, 0x5257);
  EXPECT_EQ(read_register_map(shipped("iai-block.yaml")).status_address, 0x9005);
  EXPECT_EQ(read_register_map(shipped("leadshine-pr0.yaml")).position_address, 0x1014);
}

TEST(RegisterMapTest, MapsThatCannotDriveACarriageAreRefused) {
  struct Case {
    const char *from, *to, *message;
  };
  for (const Case& each :
       {Case{kMinimal, "", "'move.address' is missing"},
        {"stop:", "stopp:", "map.yaml:9: unknown key 'stopp"},
        {"bit: 15", "bit: 16", "'status.alarm.bit'"},
        {"steps_per_mm: 80", "steps_per_mm: 0", "map.yaml:2: 'steps_per_mm'"},
        {"address: 0x20", "address: 0x10000", "'move.address'"},
        {"name: small\n", "", "'name' is missing"},
        {"steps_per_mm: 80\n", "", "'steps_per_mm' is missing"},
        {"speed_per_mm_s: 2\n", "", "'speed_per_mm_s' is missing"},
        {"position_address: 10\n", "", "'position_address' is missing"},
        {"status_address: 12\n", "", "'status_address' is missing"},
        {"stop: {address: 1, words: [2]}\n", "", "'stop.address' is missing"},
        {"words: [2]", "words: []", "'stop.words' is missing"},
        {"position_low, ", "", "position_high and position_low"},
        {"position_low, ", "position_low, position_low, ", "position_high and position_low"},
        {"position_low, ", "position_low, speed_low, ", "speed_high and speed_low"},
        {"acceleration_per_mm_s2: 1", "acceleration_time_to_mm_s: 0", "give one of"},
        {"acceleration_per_mm_s2: 1", "acceleration_per_mm_s2: 1\nacceleration_time_to_mm_s: 1",
         "give one of"},
        {"status: {alarm: {bit: 15, active_low: true}}\n", "", "'status.alarm.bit'"},
        {"words: [2]", "words: [position_low]", "'stop.words' must be numbers"},
        {"position_low", "position_lo", "did you mean 'position_low'?"},
        {"words: [2]", "words: [70000]", "70000 does not fit 16 bits"},
        {"words: [2]", "words: [-1]", "does not fit 16 bits"},
        {"address: 0x20", "address: 0xffff", "reaches beyond register 0xffff"},
        {"status_address: 12", "status_address: 200\none_read: true", "'one_read'"}}) {
    EXPECT_THAT(error_of([&] { parsed(with(each.from, each.to)); }),
                AllOf(HasSubstr(each.message), HasSubstr("map.yaml")));
  }
  EXPECT_THROW(read_register_map("/nowhere/map.yaml"), UsageError);
  // One that fills a request.
  EXPECT_TRUE(parsed(with("status_address: 12", "status_address: 134\none_read: true")).one_read);
}

double log_uniform(double low, double high, std::mt19937_64* random) {
  return std::exp(std::uniform_real_distribution(std::log(low), std::log(high))(*random));
}

std::vector<std::uint16_t> move_words(const RegisterMap& map, double mm,
                                      const MotionProfile& profile = {}) {
  return words_of(map, map.move, mm, profile);
}

TEST(RegisterWordsTest, PositionsSurviveTheRegistersToHalfAStep) {
  std::mt19937_64 random(7);
  RegisterMap map = simple_map();
  for (int i = 0; i < 20000; ++i) {
    map.steps_per_mm = log_uniform(1e-3, 1e7, &random);
    const double sign = random() % 2 == 0 ? 1.0 : -1.0;
    const double steps = log_uniform(1e-3, 2147483646.0, &random);
    const double mm = sign * std::min(steps / map.steps_per_mm, 1e9);
    const auto words = move_words(map, mm);
    map.low_word_first = false;
    EXPECT_NEAR(mm_from_words(map, words[0], words[1]), mm, 0.5 / map.steps_per_mm * (1.0 + 1e-6));
    map.low_word_first = true;
    EXPECT_EQ(mm_from_words(map, words[1], words[0]), steps_from_mm(map, mm) / map.steps_per_mm);
  }
}

TEST(RegisterWordsTest, TargetsBeyond32BitsAreRefused) {
  const RegisterMap map = simple_map(1e6);
  EXPECT_EQ(steps_from_mm(map, 2147.483647), 2147483647);
  EXPECT_EQ(steps_from_mm(map, -2147.483648), -2147483647 - 1);
  EXPECT_THROW(steps_from_mm(map, 2147.4836475), UsageError);
  EXPECT_THROW(steps_from_mm(map, -2147.4836486), UsageError);
  EXPECT_THROW(move_words(map, 1e8), UsageError);
}

// The example of the CS2RS manual: 10000 steps at 200 turns per minute.
TEST(RegisterWordsTest, LeadshineBlockMatchesItsManual) {
  RegisterMap map = simple_map(250.0, {{kConstant, 1},
                                       {kPositionHigh},
                                       {kPositionLow},
                                       {kSpeed},
                                       {kAcceleration},
                                       {kDeceleration},
                                       {kConstant, 0},
                                       {kConstant, 0x10}});
  map.speed_per_mm_s = 1.5;
  map.acceleration_per_mm_s2 = 0.0;
  map.acceleration_time_to_mm_s = 2000.0 / 3.0;
  EXPECT_THAT(move_words(map, 40.0, {400.0 / 3.0, 200.0 / 3.0}),
              ElementsAre(1, 0, 10000, 200, 10000, 10000, 0, 0x10));
}

TEST(RegisterWordsTest, WideSpeedsTakeTwoWords) {
  RegisterMap map = simple_map(1.0, {{kSpeedHigh}, {kSpeedLow}});
  map.speed_per_mm_s = 1000.0;
  EXPECT_THAT(move_words(map, 0.0, {100.0, 1.0}), ElementsAre(1, 34464));
}

TEST(RegisterWordsTest, SpeedsThatDoNotFitAreRefusedAndNotRoundedIntoRange) {
  const RegisterMap map = simple_map(1.0, {{kSpeed}, {kAcceleration}});
  EXPECT_THAT(move_words(map, 0.0, {65535.0, 65535.0}), ElementsAre(65535, 65535));
  for (const MotionProfile& profile :
       {MotionProfile{65536.0, 1.0}, {0.4, 1.0}, {1.0, 0.4}, {1.0, 65536.0}}) {
    EXPECT_THROW(move_words(map, 0.0, profile), UsageError);
  }
}

// --- The link ------------------------------------------------------------------------------------

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

Replies lost(int, const Bytes&, const Bytes&) { return {}; }
Replies whole(int, const Bytes&, const Bytes& reply) { return {{0.0, reply}}; }
Replies late(int, const Bytes&, const Bytes& reply) { return {{kTimeout_ms * 1.5, reply}}; }
Replies doubled(int, const Bytes&, const Bytes& reply) { return {{0.0, reply}, {0.0, reply}}; }
Replies truncated(int, const Bytes&, const Bytes& reply) {
  return {{0.0, {reply.begin(), reply.end() - 3}}};
}
Replies damaged(int, const Bytes&, Bytes reply) {
  reply[4] ^= 0x10;
  return {{0.0, reply}};
}

// Every reading has the value of its address, whatever happened to a reply before it. After a
// timeout a late reply is still pending, which libmodbus alone takes for the next one.
TEST_P(ModbusLinkTest, ReadingsAreRightAfterAnyFaultOfAReply) {
  struct Case {
    const char* fault;
    Script replies;
    double timeout_ms = kTimeout_ms;
  };
  std::vector<Case> cases{
      {"lost", lost},
      {"late", late},
      {"doubled", doubled},
      {"truncated", truncated},
      {"of two words instead of one, in a valid frame", always({1, 3, 4, 9, 9, 9, 9})},
      {"busy", always({1, 0x83, 6}), kLongTimeout_ms}};
  if (GetParam() == SliderConnection::kRtu) cases.push_back({"damaged", damaged});
  for (const Case& each : cases) {
    SCOPED_TRACE(each.fault);
    const auto every_third = [&](int n, const Bytes& request, const Bytes& reply) {
      return (n % 3 == 1 ? each.replies : whole)(n, request, reply);
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
  LinkRig rig(GetParam(), lost);
  rig.expect_fault(FaultKind::kNoContact, "tries: 3); check the drive's power");
  EXPECT_GE(rig.requests(), 3);
}

TEST_P(ModbusLinkTest, UnansweredWriteIsNotRepeated) {
  LinkRig rig(GetParam(), [](int n, const Bytes& request, const Bytes& reply) {
    return (n == 0 ? lost : whole)(n, request, reply);
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
  // The server opens its lines again within milliseconds.
  const auto is_back = [&] { return error_of([&] { rig.read(1); }) == "no error"; };
  for (int attempt = 0; attempt < 10 && !is_back(); ++attempt) {
  }
  EXPECT_EQ(rig.read(1), 1001);
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
