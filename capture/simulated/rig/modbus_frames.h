// Modbus requests taken out of a stream of bytes, and replies put into one, for the drive's side.
// Sources: "MODBUS over Serial Line" 1.02 and "MODBUS Messaging on TCP/IP Implementation Guide"
// 1.0b of the Modbus Organization.
//
// This is written independently of libmodbus, which the driver uses, so that a mistake is not made
// the same way on both sides.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "capture/simulated/rig/link_faults.h"

namespace raywalk::capture {

struct ModbusRequest {
  std::uint16_t transaction = 0;  // TCP only
  std::uint8_t unit = 0;
  ModbusBytes pdu{};  // function code and data
};

// The word at two bytes, high byte first.
inline std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

// CRC-16 of the serial line: the polynomial 0xa001 (bits reversed), started at 0xffff.
std::uint16_t modbus_crc(std::span<const std::uint8_t> bytes);

// Frames with their checksum (low byte first), or their MBAP header.
ModbusBytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu);
ModbusBytes tcp_frame(std::uint16_t transaction, std::uint8_t unit,
                      std::span<const std::uint8_t> pdu);

// A frame on the serial line ends with silence, which a pseudo-terminal does not keep; so the
// length that its function code demands ends it here. Silence still does what it is for: it drops
// half a request, or what follows a wrong checksum.
class RtuReceiver {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void add(std::span<const std::uint8_t> bytes, Time now);
  std::optional<ModbusRequest> next();

 private:
  std::size_t frame_length() const;

  ModbusBytes buffer_;
  Time last_byte_{};
  bool lost_track_ = false;
};

// Over TCP the header has the length.
class TcpReceiver {
 public:
  void add(std::span<const std::uint8_t> bytes);
  std::optional<ModbusRequest> next();
  // Whether what came is not Modbus: the connection is of no more use.
  bool is_broken() const { return broken_; }

 private:
  ModbusBytes buffer_;
  bool broken_ = false;
};

}  // namespace raywalk::capture
