// Modbus server of the simulated drive: RTU on a pseudo-terminal and TCP on loopback, concurrently.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "simulator/rig/drive_registers.h"
#include "simulator/rig/link_faults.h"

namespace raywalk::capture {

struct ModbusServerSettings {
  int unit = 1;                         // Modbus address, 1 to 247
  std::filesystem::path serial_link{};  // symbolic link to the pseudo-terminal; empty: no RTU
  std::optional<int> tcp_port{};        // 0: any free port; empty: no TCP
};

// Serves from construction to destruction, in its own thread. Requests to other units are ignored;
// requests to unit 0 (broadcast) are executed without a reply. Over TCP, units 0 and 255 also
// address the drive, as the Modbus guide recommends. Clients may connect at any time, several over
// TCP.
//
// While the link is cut (LinkFaults::cut), the pseudo-terminal hangs up, its symbolic link is
// removed, as with an unplugged adapter, and TCP connections are reset. Afterwards a new
// pseudo-terminal is linked under the same name.
class ModbusServer {
 public:
  // `registers` and `faults` must outlive the server. Throws Error if the port is in use or the
  // symbolic link cannot be created.
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
