// The simulated drive on its lines: Modbus RTU on a pseudo-terminal and Modbus TCP on loopback,
// concurrently, answered by libmodbus.
#pragma once

#include <modbus/modbus.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "simulator/rig/drive_registers.h"
#include "simulator/rig/faults.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {

// Bytes that are sent `after_ms` after a request.
struct TimedBytes {
  double after_ms = 0.0;
  std::vector<std::uint8_t> bytes{};
};

struct DriveServerSettings {
  int unit = 1;                         // Modbus address, 1 to 247
  std::filesystem::path serial_link{};  // symbolic link to the pseudo-terminal; empty: no RTU
  std::optional<int> tcp_port{};        // 0: any free port; empty: no TCP
  // For tests: what is sent instead of the correct reply to a request, in order of time.
  std::function<std::vector<TimedBytes>(const std::vector<std::uint8_t>& request,
                                        const std::vector<std::uint8_t>& reply)>
      line{};
};

// Serves from construction to destruction, in its own thread, one request after the other. Requests
// to unit 0 (broadcast) are executed, over RTU without a reply. Those to other units are ignored;
// over RTU so is the next message, which libmodbus takes for their reply. Over TCP, unit 255 also
// addresses the drive, as the Modbus guide recommends. Clients may connect at any time, several
// over TCP.
//
// While the link is cut, the pseudo-terminal hangs up, its symbolic link is removed, as with an
// unplugged adapter, and TCP connections are closed. Afterwards a new pseudo-terminal is linked
// under the same name.
class DriveServer {
 public:
  // Drive and faults must outlive the server. Throws Error if the port is in use or the symbolic
  // link cannot be created.
  DriveServer(const DriveServerSettings& settings, const RegisterMap& map, SimulatedDrive* drive,
              Faults* faults);
  ~DriveServer();
  DriveServer(const DriveServer&) = delete;
  DriveServer& operator=(const DriveServer&) = delete;

  int tcp_port() const;  // 0 without TCP

 private:
  struct Free {
    void operator()(modbus_t* context) const { modbus_free(context); }
  };
  using Context = std::unique_ptr<modbus_t, Free>;
  class Terminal;
  using Bytes = std::vector<std::uint8_t>;

  void run();
  void connect_or_hang_up();
  void wait_for_requests();
  bool serve(modbus_t* context, int line);
  Bytes reply_to(modbus_t* context, const std::uint8_t* request, int length);
  Bytes taken_reply() const;
  std::vector<TimedBytes> sent_for(std::optional<RigFault> fault, Bytes reply, bool is_tcp);
  void close_lines();

  const DriveServerSettings settings_;
  DriveRegisters registers_;
  Faults* faults_;
  HashRandom damage_;
  Context rtu_;
  Context tcp_;
  std::unique_ptr<Terminal> terminal_;
  int listener_ = -1;
  std::vector<int> clients_;
  // libmodbus writes its replies into the first; they are read from the second, so that faults of
  // the link can be applied to them.
  std::array<int, 2> replies_{-1, -1};
  std::atomic<bool> over_{false};
  std::thread thread_;  // last, as it uses all of the above
};

}  // namespace raywalk::simulator
