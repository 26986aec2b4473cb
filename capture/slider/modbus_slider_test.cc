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

// Registers in memory that count requests.
class FakeRegisters final : public RegisterLink {
 public:
  struct Write {
    int address;
    std::vector<std::uint16_t> words;
  };

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
  ModbusSlider slider(const RegisterMap& map) {
    auto link = std::make_unique<FakeRegisters>();
    registers = link.get();
    return {std::move(link), map, 3};
  }
  static SafePosition at(double mm) { return SoftLimits(-1e9, 1e9).require(mm, "test"); }

  FakeRegisters* registers = nullptr;
};

TEST_F(ModbusSliderTest, ReadsAdjacentRegistersInOneRequest) {
  ModbusSlider drive = slider(simple_map());
  registers->values = {{0, 0x0008}, {1, 0xffff}, {2, 0xff9c}};
  const SliderState state = drive.read_state();
  EXPECT_EQ(state.position_mm, -10.0);
  EXPECT_EQ(state.moving, true);
  EXPECT_EQ(state.homed, std::nullopt);
  EXPECT_FALSE(state.alarm);
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(0, 3)));
}

TEST_F(ModbusSliderTest, ReadsAcrossAGapOnlyIfTheMapAllows) {
  RegisterMap map = simple_map();
  map.status_address = 9;
  map.input_registers = true;
  ModbusSlider apart = slider(map);
  apart.read_state();
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(9, 1), std::pair(1, 2)));
  EXPECT_EQ(registers->last_kind, RegisterKind::kInput);
  map.one_read = true;
  ModbusSlider together = slider(map);
  registers->values = {{9, 0x0008}, {2, 50}};
  const SliderState state = together.read_state();
  EXPECT_THAT(registers->reads, ElementsAre(std::pair(1, 9)));
  EXPECT_EQ(state.position_mm, 5.0);
  EXPECT_EQ(state.moving, true);
}

TEST_F(ModbusSliderTest, AlarmCodeIsReadDuringAnAlarmOnly) {
  RegisterMap map = simple_map();
  map.alarm_address = 40;
  ModbusSlider drive = slider(map);
  registers->values = {{40, 0x00e0}};
  EXPECT_EQ(drive.read_state().alarm_code, 0);
  EXPECT_EQ(registers->reads.size(), 1u);
  registers->values[0] = 1;
  EXPECT_EQ(drive.read_state().alarm_code, 0xe0);
}

TEST_F(ModbusSliderTest, AnotherDeviceIsNoticedAtEveryOpening) {
  RegisterMap map = simple_map();
  map.identity_address = 50;
  map.identity_value = 0x1234;
  ModbusSlider drive = slider(map);
  registers->values[50] = 0x1234;
  EXPECT_NO_THROW(drive.read_state());
  registers->values[50] = 0x4321;
  EXPECT_NO_THROW(drive.read_state());
  registers->openings_count = 2;
  expect_fault(FaultKind::kWrongDevice, "register 0x0032 holds 0x4321, not 0x1234",
               [&] { drive.read_state(); });
}

TEST_F(ModbusSliderTest, ImpossibleReadingsTwiceInARowAreAWrongDevice) {
  ModbusSlider drive = slider(simple_map());
  registers->nonsense = 1;
  EXPECT_NO_THROW(drive.read_state());
  registers->nonsense = 2;
  expect_fault(FaultKind::kWrongDevice, "(status 0xffff, position -0 mm); check the register map",
               [&] { drive.read_state(); });
}

TEST_F(ModbusSliderTest, WrongOrderOfThePositionsWordsIsNamed) {
  ModbusSlider drive = slider(simple_map());
  registers->values = {{1, 1234}, {2, 0}};
  expect_fault(FaultKind::kWrongDevice,
               "words are 123.400 mm: if the carriage is there, set low_word_first to true",
               [&] { drive.read_state(); });
  registers->values = {{1, 0xff00}, {2, 0xffff}};
  expect_fault(FaultKind::kWrongDevice, "words are -25.600 mm", [&] { drive.read_state(); });
  registers->values = {{1, 0x7fff}, {2, 0x7ffe}};
  expect_fault(FaultKind::kWrongDevice, "check the register map against",
               [&] { drive.read_state(); });
}

TEST_F(ModbusSliderTest, MoveWritesTheBlockAndThenTheStart) {
  RegisterMap map = simple_map();
  map.start = RegisterWrite{20, {{WordMeaning::kConstant, 1}}};
  ModbusSlider drive = slider(map);
  drive.start_move(at(7000.0), MotionProfile{});
  ASSERT_EQ(registers->writes.size(), 2u);
  EXPECT_EQ(registers->writes[0].address, 16);
  EXPECT_THAT(registers->writes[0].words, ElementsAre(1, 4464));  // 70000 steps
  EXPECT_EQ(registers->writes[1].address, 20);
}

TEST_F(ModbusSliderTest, TargetBeyondTheRegistersIsRefusedBeforeWriting) {
  ModbusSlider drive = slider(simple_map());
  EXPECT_THROW(drive.start_move(at(3e8), MotionProfile{}), UsageError);
  EXPECT_TRUE(registers->writes.empty());
}

TEST_F(ModbusSliderTest, UnansweredMoveIsRepeatedOnlyIfNotExecuted) {
  ModbusSlider lost = slider(simple_map());
  registers->unanswered = {0};
  lost.start_move(at(100.0), MotionProfile{});
  EXPECT_EQ(registers->writes.size(), 2u);
  EXPECT_EQ(registers->reads.size(), 1u);

  ModbusSlider taken = slider(simple_map());
  registers->unanswered = {0};
  registers->take_unanswered = true;
  taken.start_move(at(100.0), MotionProfile{});
  EXPECT_EQ(registers->writes.size(), 1u);
}

TEST_F(ModbusSliderTest, MoveThatIsNeverAnsweredIsLostContact) {
  ModbusSlider drive = slider(simple_map());
  registers->unanswered = {0, 1, 2, 3};
  expect_fault(FaultKind::kNoContact, "does not answer a write to register 0x0010 (tries: 3)",
               [&] { drive.start_move(at(100.0), MotionProfile{}); });
  EXPECT_EQ(registers->writes.size(), 3u);
}

TEST_F(ModbusSliderTest, StopIsRepeatedAtOnceWithoutReading) {
  ModbusSlider drive = slider(simple_map());
  registers->unanswered = {0, 1};
  drive.stop();
  EXPECT_EQ(registers->writes.size(), 3u);
  EXPECT_EQ(registers->writes.back().words.front(), 3);
  EXPECT_TRUE(registers->reads.empty());
}

TEST_F(ModbusSliderTest, ResetNeedsARegister) {
  ModbusSlider without = slider(simple_map());
  EXPECT_THROW(without.reset_alarm(), DeviceFault);
  RegisterMap map = simple_map();
  map.reset_alarm = RegisterWrite{33, {{WordMeaning::kConstant, 9}}};
  ModbusSlider with = slider(map);
  with.reset_alarm();
  EXPECT_EQ(registers->writes.front().words.front(), 9);
}

TEST_F(ModbusSliderTest, HomingWritesItsWords) {
  ModbusSlider drive = slider(simple_map());
  drive.start_homing();
  EXPECT_EQ(registers->writes.front().address, 32);
  EXPECT_THAT(drive.description(), HasSubstr("test, unit 1 in memory"));
}

}  // namespace
}  // namespace raywalk::capture
