#include "simulator/rig/drive_registers.h"

#include <gtest/gtest.h>

#include "capture/base/manual_clock.h"
#include "simulator/rig/test_maps.h"

namespace raywalk::capture {
namespace {

class DriveRegistersTest : public ::testing::Test {
 protected:
  static DriveSettings settings() {
    DriveSettings settings;
    settings.backlash_mm = 0.0;
    settings.power_on_mm = 100.0;
    return settings;
  }
  void pass(double ms) { clock_.sleep(duration_from_ms(ms)); }

  ManualClock clock_;
  SimulatedDrive drive_{settings(), &clock_};
};

constexpr std::uint8_t kHomeHigh = 0x60, kHomeLow = 0x02;

TEST_F(DriveRegistersTest, OneWriteMovesAndStateReadsBack) {
  DriveRegisters registers(one_write_map(), &drive_);
  const ModbusBytes home{6, kHomeHigh, kHomeLow, 0x00, 0x20};
  EXPECT_EQ(registers.answer(home), home);
  pass(60000.0);
  EXPECT_TRUE(drive_.state().homed);
  // To -10.00 mm = -1000 steps at 60 units = 100 mm/s, accelerating 1000 mm/s in 5000 ms.
  const ModbusBytes move{16,   0x62, 0x00, 0,    8,    16,   0,    1, 0xff, 0xff, 0xfc,
                         0x18, 0,    60,   0x13, 0x88, 0x13, 0x88, 0, 0,    0,    0x10};
  EXPECT_EQ(registers.answer(move), (ModbusBytes{16, 0x62, 0x00, 0, 8}));
  pass(100.0);
  // 200 mm/s^2 for 0.1 s: 1 mm.
  EXPECT_NEAR(drive_.state().feedback_mm, -1.0, 1e-6);
  // moving, enabled, homed
  EXPECT_EQ(registers.answer(ModbusBytes{3, 0x10, 0x03, 0, 1}), (ModbusBytes{3, 2, 0, 0x46}));
  pass(60000.0);
  EXPECT_EQ(registers.answer(ModbusBytes{3, 0x10, 0x14, 0, 2}),
            (ModbusBytes{3, 4, 0xff, 0xff, 0xfc, 0x18}));
  EXPECT_EQ(registers.answer(ModbusBytes{3, 0x10, 0x03, 0, 1}), (ModbusBytes{3, 2, 0, 0x52}));
  // Written values can be read back.
  EXPECT_EQ(registers.answer(ModbusBytes{3, 0x62, 0x01, 0, 2}),
            (ModbusBytes{3, 4, 0xff, 0xff, 0xfc, 0x18}));
}

TEST_F(DriveRegistersTest, StatusAndPositionCanBeReadInOneExchange) {
  DriveRegisters registers(one_write_map(), &drive_);
  const ModbusBytes reply = registers.answer(ModbusBytes{3, 0x10, 0x03, 0, 0x13});
  ASSERT_EQ(reply.size(), 2U + 2U * 0x13);
  EXPECT_EQ(reply[3], 0x12);  // enabled, in position
}

TEST_F(DriveRegistersTest, MoveWaitsForItsStart) {
  DriveRegisters registers(two_write_map(), &drive_);
  registers.answer(ModbusBytes{6, 0, 111, 0, 1});
  pass(60000.0);
  // 70.000 mm = 0x00011170 steps, low word first; 0x000186a0 = 100 mm/s; 2000 = 200 mm/s^2.
  registers.answer(ModbusBytes{16, 0, 100, 0, 5, 10, 0x11, 0x70, 0x00, 0x01, 0x86, 0xa0, 0x00, 0x01,
                               0x07, 0xd0});
  pass(1000.0);
  EXPECT_EQ(drive_.truth().moves, 0);
  registers.answer(ModbusBytes{6, 0, 110, 0, 1});
  pass(500.0);
  EXPECT_NEAR(drive_.state().feedback_mm, 25.0, 1e-6);
  pass(60000.0);
  // Identity, status (the alarm is active low), position: all in one.
  EXPECT_EQ(registers.answer(ModbusBytes{4, 0, 0, 0, 5}),
            (ModbusBytes{4, 10, 0x52, 0x57, 0x00, 0x0a, 0x11, 0x70, 0x00, 0x01, 0, 0}));
}

TEST_F(DriveRegistersTest, StopAndAlarmReset) {
  DriveRegisters registers(two_write_map(), &drive_);
  drive_.move_to(1000.0, {100.0, 1000.0, 1000.0});
  pass(1000.0);
  registers.answer(ModbusBytes{6, 0, 112, 0, 1});
  pass(1000.0);
  EXPECT_FALSE(drive_.state().moving);
  drive_.inject(DriveFault::kAlarm, 0x321, Duration::zero());
  EXPECT_EQ(registers.answer(ModbusBytes{4, 0, 4, 0, 1}), (ModbusBytes{4, 2, 0x03, 0x21}));
  EXPECT_EQ(registers.answer(ModbusBytes{4, 0, 1, 0, 1}), (ModbusBytes{4, 2, 0, 0}));
  registers.answer(ModbusBytes{6, 0, 113, 0, 1});
  EXPECT_FALSE(drive_.state().alarm);
}

TEST_F(DriveRegistersTest, WriteWithoutTheTriggerIsStoredWithoutMoving) {
  DriveRegisters registers(one_write_map(), &drive_);
  const ModbusBytes move{16,   0x62, 0x00, 0,    8,    16,   0,    1, 0, 0, 0xfc,
                         0x18, 0,    60,   0x13, 0x88, 0x13, 0x88, 0, 0, 0, 0};
  EXPECT_EQ(registers.answer(move), (ModbusBytes{16, 0x62, 0x00, 0, 8}));
  registers.answer(ModbusBytes{6, 0x62, 0x00, 0, 1});
  EXPECT_EQ(drive_.truth().moves, 0);
}

TEST_F(DriveRegistersTest, InvalidRequestsAreAnsweredWithExceptions) {
  DriveRegisters registers(one_write_map(), &drive_);
  const auto expect_exception = [&](const ModbusBytes& request, std::uint8_t code) {
    EXPECT_EQ(registers.answer(request),
              (ModbusBytes{static_cast<std::uint8_t>(request[0] | 0x80), code}));
  };
  expect_exception({0x2b, 0x0e, 1, 0}, 1);
  expect_exception({4, 0x10, 0x14, 0, 2}, 2);         // state is in holding registers
  expect_exception({3, 0x00, 0x00, 0, 1}, 2);         // not in the map
  expect_exception({3, 0x22, 0x03, 0, 2}, 2);         // one past the end
  expect_exception({6, 0x10, 0x14, 0, 1}, 2);         // feedback cannot be written
  expect_exception({3, 0x10, 0x14, 0, 0}, 3);         // no registers
  expect_exception({3, 0x10, 0x14, 0, 126}, 3);       // too many
  expect_exception({3, 0x10}, 3);                     // truncated
  expect_exception({16, 0x62, 0, 0, 2, 2, 0, 1}, 3);  // bytes do not match the count
  // A move at speed 0.
  expect_exception(
      {16, 0x62, 0x00, 0, 8, 16, 0, 1, 0, 0, 0, 1, 0, 0, 0x13, 0x88, 0x13, 0x88, 0, 0, 0, 0x10}, 3);
  EXPECT_EQ(drive_.truth().moves, 0);
  EXPECT_EQ(registers.answer({}), (ModbusBytes{0x80, 1}));
}

}  // namespace
}  // namespace raywalk::capture
