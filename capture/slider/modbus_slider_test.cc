#include "capture/slider/modbus_slider.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/test_fault.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Write {
  int address;
  std::vector<std::uint16_t> words;
  friend bool operator==(const Write&, const Write&) = default;
};

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
    writes.push_back({address, {words.begin(), words.end()}});
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

RegisterMap simple_map() {
  RegisterMap map;
  map.name = "test";
  map.steps_per_mm = 10.0;
  map.status_address = 0;
  map.position_address = 1;
  map.speed_per_mm_s = 1.0;
  map.acceleration_per_mm_s2 = 1.0;
  map.move = {16, {{WordMeaning::kPositionHigh}, {WordMeaning::kPositionLow}}};
  map.home = {32, {{WordMeaning::kConstant, 2}}};
  map.stop = {32, {{WordMeaning::kConstant, 3}}};
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
  use(map);
  registers->values = {{40, 0x00e0}};
  EXPECT_EQ(drive->read_state().alarm_code, 0);
  EXPECT_EQ(registers->reads.size(), 1u);
  registers->values[0] = 1;
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
  map.start = RegisterWrite{20, {{WordMeaning::kConstant, 1}}};
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

}  // namespace
}  // namespace raywalk::capture
