// The Modbus registers of the simulated drive, laid out according to a register map.
#pragma once

#include <modbus/modbus.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "capture/slider/register_map.h"
#include "simulator/rig/simulated_drive.h"

namespace raywalk::simulator {

using capture::BlockWord;
using capture::RegisterMap;
using capture::RegisterWrite;
using capture::StatusBit;
using capture::WordMeaning;

// libmodbus answers requests from a mapping of all registers; those that the register map does not
// use can be written and read back. Writing a whole block with the
// constants of the map executes its command: immediately, or for a move with a `start` block once
// that is written.
class DriveRegisters {
 public:
  // The drive must outlive this object.
  DriveRegisters(const RegisterMap& map, SimulatedDrive* drive);

  // The registers with the drive's present state, for modbus_reply.
  modbus_mapping_t* refreshed();
  // Executes the command, if any, that a write of `count` registers completed. False: the drive
  // refuses its values.
  bool execute(int address, int count);

 private:
  struct Free {
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
  };

  std::uint16_t& word_at(int address) const;
  void set_state(int address, int value) const;
  int status_word(const DriveState& state) const;
  bool was_written(const RegisterWrite& block, int address, int count) const;
  double acceleration_of(std::uint16_t units) const;
  std::optional<std::uint16_t> word_of_move(WordMeaning meaning) const;
  bool start_move() const;

  const RegisterMap map_;
  SimulatedDrive* drive_;
  std::unique_ptr<modbus_mapping_t, Free> mapping_;
};

}  // namespace raywalk::simulator
