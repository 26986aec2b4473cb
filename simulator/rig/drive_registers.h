// The Modbus registers of the simulated drive, laid out according to a register map.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "capture/slider/register_map.h"
#include "simulator/rig/link_faults.h"
#include "simulator/rig/simulated_drive.h"

namespace raywalk::capture {

// Supports functions 3, 4, 6 and 16 and exceptions 1 (function), 2 (address) and 3 (value) of the
// "MODBUS Application Protocol" 1.1b3.
//
// State is read with the function that the map specifies. Writing a whole block with the constants
// of the map executes its command: immediately, or for a move with a `start` block once that is
// written. Any other write within the blocks is stored and can be read back.
class DriveRegisters {
 public:
  // The drive must outlive this object.
  DriveRegisters(const RegisterMap& map, SimulatedDrive* drive);

  // Returns the PDU of the reply to a request PDU; both start with the function code.
  ModbusBytes answer(std::span<const std::uint8_t> pdu);

 private:
  // A decoded command block, in register units; 0 for words that the block does not have.
  struct Command {
    std::int64_t position_steps = 0;
    std::int64_t speed = 0;
    std::int64_t acceleration = 0;
    std::int64_t deceleration = 0;
    bool has_speed = false;
    bool has_acceleration = false;
    bool has_deceleration = false;
  };

  ModbusBytes read(int function, int address, int count);
  ModbusBytes write(int function, int address, std::span<const std::uint16_t> words);
  std::map<int, std::uint16_t> state_words();
  std::uint16_t status_word(const DriveState& state) const;
  bool is_writable(int address) const;
  bool was_written(const RegisterWrite& block, int address, std::size_t count) const;
  Command command_of(const RegisterWrite& block) const;
  bool start_move(const Command& command);
  double acceleration_of(std::int64_t units) const;

  const RegisterMap map_;
  SimulatedDrive* drive_;
  std::map<int, std::uint16_t> written_;
};

}  // namespace raywalk::capture
