// The drive's side of the Modbus link: RTU on a pseudo-terminal and TCP on loopback, at once.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "capture/simulated/rig/drive_registers.h"
#include "capture/simulated/rig/link_faults.h"

namespace raywalk::capture {

struct ModbusServerSettings {
  int unit = 1;                         // Modbus address, 1 to 247
  std::filesystem::path serial_link{};  // link to the pseudo-terminal; empty: none
  std::optional<int> tcp_port{};        // 0: one that is free
};

// Serves from its construction to its destruction, in a thread of its own. A request to another
// unit gets no answer, one to unit 0 (all) is obeyed without one; over TCP units 0 and 255 mean the
// drive as well, as the Modbus guide recommends. Clients may come and go, over TCP several at once.
//
// A cut line (LinkFaults::cut) hangs up the pseudo-terminal and takes its link away, as an adapter
// that is unplugged, and resets all TCP connections; when it is over there is a new
// pseudo-terminal by the same link.
class ModbusServer {
 public:
  // Registers and faults have to outlive it. Throws Error: the port is taken, the link cannot be
  // made.
  ModbusServer(const ModbusServerSettings& settings, DriveRegisters* registers, LinkFaults* faults);
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  int tcp_port() const;  // 0 without TCP

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace raywalk::capture
