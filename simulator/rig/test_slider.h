// For tests: the slider driver on the simulated drive, in process and in simulated time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/base/device_fault.h"
#include "capture/base/manual_clock.h"
#include "capture/slider/modbus_slider.h"
#include "simulator/rig/drive_registers.h"

namespace raywalk::capture {

using simulator::DriveRegisters;
using simulator::DriveSettings;
using simulator::Fault;
using simulator::Faults;
using simulator::RigFault;
using simulator::SimulatedDrive;

// A drive whose carriage is at `start_mm`, homed or not, and its driver. Time passes while it is
// homed, before the constructor returns. Of the faults of the link there are three here: kCut,
// while which every request fails and the carriage keeps moving, kLostRequest, by which one fails,
// and kCorruptedReply, which puts one reading of the position off by `amount` millimetres.
class TestSlider {
 public:
  struct Setup {
    double start_mm = 0.0;
    bool homed = true;
    bool reports_flags = true;  // whether the drive reports moving, homed, in position, ...
    double noise_mm = 0.0;
    double backlash_mm = 0.0;
    double max_speed_mm_s = 1e6;
    double max_acceleration_mm_s2 = 5000.0;
    int seed = 1;
  };

  TestSlider(const Setup& setup, ManualClock* clock)
      : faults(clock), drive(settings_of(setup), clock, &faults) {
    auto link = std::make_unique<Link>(this, map_of(setup.reports_flags));
    driver_ = std::make_unique<ModbusSlider>(std::move(link), map_of(setup.reports_flags), 1);
    if (setup.homed) {
      drive.home();
      clock->sleep(std::chrono::seconds(60));
      drive.move_to(setup.start_mm, {1000.0, 1000.0, 1000.0});
      clock->sleep(std::chrono::seconds(60));
      moves_before_ = drive.truth().moves;
    }
    lowest_mm_ = highest_mm_ = true_position_mm();
  }

  ModbusSlider* driver() { return driver_.get(); }
  double true_position_mm() { return drive.truth().carriage_mm; }
  bool is_moving() { return !drive.truth().still_for; }
  int moves_commanded() { return drive.truth().moves - moves_before_; }
  int stops_commanded() const { return stops_; }
  double lowest_mm() const { return lowest_mm_; }    // of true positions at any reading
  double highest_mm() const { return highest_mm_; }  // or command

  Faults faults;
  SimulatedDrive drive;
  bool ignores_commands = false;  // other than stop
  bool ignores_stop = false;

 private:
  class Link final : public RegisterLink {
   public:
    Link(TestSlider* owner, const RegisterMap& map)
        : owner_(owner), map_(map), registers_(map, &owner->drive) {}

    std::string description() const override { return "simulated drive"; }
    int openings() const override { return 1; }
    std::vector<std::uint16_t> read(RegisterKind /*kind*/, int address, int count) override {
      owner_->track();
      require_contact();
      const modbus_mapping_t* mapping = registers_.refreshed();
      const std::uint16_t* first = mapping->tab_registers + address;
      std::vector<std::uint16_t> words(first, first + count);
      if (address != map_.status_address) return words;
      if (const auto off_mm = owner_->faults.occurs(RigFault::kCorruptedReply)) {
        const auto steps = static_cast<std::uint32_t>(words[1]) << 16 | words[2];
        const auto off = steps + static_cast<std::uint32_t>(
                                     static_cast<std::int32_t>(*off_mm * map_.steps_per_mm));
        words[1] = static_cast<std::uint16_t>(off >> 16);
        words[2] = static_cast<std::uint16_t>(off & 0xffff);
      }
      return words;
    }
    bool write(int address, std::span<const std::uint16_t> words) override {
      owner_->track();
      require_contact();
      const bool is_stop = address == map_.stop.address;
      if (is_stop) ++owner_->stops_;
      if (is_stop ? owner_->ignores_stop : owner_->ignores_commands) return true;
      const modbus_mapping_t* mapping = registers_.refreshed();
      std::copy(words.begin(), words.end(), mapping->tab_registers + address);
      return registers_.execute(address, static_cast<int>(words.size()));
    }

   private:
    void require_contact() const {
      const bool is_lost = owner_->faults.lasting(RigFault::kCut).has_value() ||
                           owner_->faults.occurs(RigFault::kLostRequest).has_value();
      if (!is_lost) return;
      throw DeviceFault(FaultKind::kNoContact, "the drive does not answer; check its cable");
    }
    TestSlider* owner_;
    RegisterMap map_;
    DriveRegisters registers_;
  };

  static DriveSettings settings_of(const Setup& setup) {
    return {.seed = setup.seed,
            .high_switch_mm = 3000.0,
            .power_on_mm = setup.homed ? 10.0 : setup.start_mm,
            .max_speed_mm_s = setup.max_speed_mm_s,
            .max_acceleration_mm_s2 = setup.max_acceleration_mm_s2,
            .homing_speed_mm_s = 100.0,
            .backlash_mm = setup.backlash_mm,
            .feedback_noise_mm = setup.noise_mm};
  }
  // Status and position lie side by side, so that one request reads both.
  static RegisterMap map_of(bool reports_flags) {
    using enum WordMeaning;
    RegisterMap map;
    map.name = "test";
    map.steps_per_mm = 1000.0;
    map.status_address = 0;
    map.position_address = 1;
    map.alarm_address = 3;
    map.speed_per_mm_s = 1000.0;
    map.acceleration_per_mm_s2 = 10.0;
    map.move = {10, {{kPositionHigh}, {kPositionLow}, {kSpeedHigh}, {kSpeedLow}, {kAcceleration}}};
    map.home = {20, {{kConstant, 1}}};
    map.stop = {21, {{kConstant, 1}}};
    map.alarm = StatusBit{0};
    if (!reports_flags) return map;
    int bit = 1;
    for (StatusBit* flag : {&map.enabled, &map.homed, &map.moving, &map.in_position,
                            &map.at_low_limit, &map.at_high_limit}) {
      *flag = StatusBit{bit++};
    }
    return map;
  }

  void track() {
    lowest_mm_ = std::min(lowest_mm_, true_position_mm());
    highest_mm_ = std::max(highest_mm_, true_position_mm());
  }

  std::unique_ptr<ModbusSlider> driver_;
  int moves_before_ = 0;
  int stops_ = 0;
  double lowest_mm_ = 0.0;
  double highest_mm_ = 0.0;
};

}  // namespace raywalk::capture
