// Access to the registers of one Modbus device, independent of the transport.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace raywalk::capture {

enum class RegisterKind { kHolding, kInput };

class RegisterLink {
 public:
  virtual ~RegisterLink() = default;

  // "unit 1 at /dev/ttyUSB0"
  virtual std::string description() const = 0;
  // How often the connection has been opened. After a change, another device may be connected.
  virtual int openings() const = 0;
  // The words of `count` registers (1 to 125). Repeats the request until the reply is complete.
  // Throws DeviceFault: kNoContact after the last try, kWrongDevice if the device refuses.
  virtual std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) = 0;
  // Sends a write of 1 to 123 words once. False: it was sent without a complete reply, so it may or
  // may not have been executed; the caller must find out. Throws DeviceFault kNoContact if it was
  // certainly not executed (no connection, device busy throughout), kWrongDevice if the device
  // refuses it.
  virtual bool write(int address, std::span<const std::uint16_t> words) = 0;
};

}  // namespace raywalk::capture
