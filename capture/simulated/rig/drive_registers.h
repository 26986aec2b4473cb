// The registers of the simulated drive, laid out as a register map says.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "capture/simulated/rig/link_faults.h"
#include "capture/simulated/rig/simulated_drive.h"
#include "capture/slider/register_map.h"

namespace raywalk::capture {

// Answers functions 3, 4, 6 and 16; exceptions 1 (function), 2 (address) and 3 (value) as the
// "MODBUS Application Protocol" 1.1b3 has them.
//
// State is read with the one function that the map names. A block that is written whole, with its
// constants as the map has them, makes the drive act: at once, or for a move with a `start` block
// once that is written. Any other write within the blocks is kept and can be read back.
class DriveRegisters {
 public:
  // The drive has to outlive it.
  DriveRegisters(const RegisterMap& map, SimulatedDrive* drive);

  // The reply's PDU to a request's PDU, function code first.
  ModbusBytes answer(std::span<const std::uint8_t> pdu);

 private:
  // What the words of a written block mean, in register units; 0 where the block has no such word.
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
