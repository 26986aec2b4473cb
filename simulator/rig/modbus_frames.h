// Server-side framing of Modbus: extracts requests from a byte stream and builds replies.
// Sources: "MODBUS over Serial Line" 1.02 and "MODBUS Messaging on TCP/IP Implementation Guide"
// 1.0b of the Modbus Organization.
//
// Written independently of libmodbus, which the driver uses, so that both sides do not share a bug.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "simulator/rig/link_faults.h"

namespace raywalk::capture {

struct ModbusRequest {
  std::uint16_t transaction = 0;  // TCP only
  std::uint8_t unit = 0;
  ModbusBytes pdu{};  // function code and data
};

// The 16-bit word at two bytes, high byte first.
inline std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

// CRC-16 of the serial line: polynomial 0xa001 (reflected), initial value 0xffff.
std::uint16_t modbus_crc(std::span<const std::uint8_t> bytes);

// A frame with checksum (low byte first), and a frame with MBAP header.
ModbusBytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu);
ModbusBytes tcp_frame(std::uint16_t transaction, std::uint8_t unit,
                      std::span<const std::uint8_t> pdu);

// Frames on the serial line end with silence, which a pseudo-terminal does not preserve, so the
// length of a frame is derived from its function code. A pause still resynchronizes: it drops an
// incomplete request and everything after a wrong checksum.
class RtuReceiver {
 public:
  using Time = std::chrono::steady_clock::time_point;

  void add(std::span<const std::uint8_t> bytes, Time now);
  std::optional<ModbusRequest> next();

 private:
  std::size_t frame_length() const;

  ModbusBytes buffer_;
  Time last_byte_{};
  bool out_of_sync_ = false;
};

// Over TCP the header holds the length.
class TcpReceiver {
 public:
  void add(std::span<const std::uint8_t> bytes);
  std::optional<ModbusRequest> next();
  // Whether the data were not Modbus; the connection should be closed.
  bool is_broken() const { return broken_; }

 private:
  ModbusBytes buffer_;
  bool broken_ = false;
};

}  // namespace raywalk::capture
