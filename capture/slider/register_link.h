// The registers of one Modbus device, whatever carries the requests.
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
  // How often the connection has been opened so far. Where it grew, another device may answer now.
  virtual int openings() const = 0;
  // The words of `count` registers (1 to 125). Repeats the request until it is answered whole.
  // Throws DeviceFault: kNoContact after the last try, kWrongDevice where the device refuses.
  virtual std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) = 0;
  // Sends a write of 1 to 123 words once. False: it was sent, and no whole answer came, so that it
  // may have been carried out or not; the caller has to find out. Throws DeviceFault kNoContact
  // where it surely was not carried out (no connection, device busy throughout), kWrongDevice where
  // the device refuses it.
  virtual bool write(int address, std::span<const std::uint16_t> words) = 0;
};

}  // namespace raywalk::capture
