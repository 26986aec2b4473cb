#include "simulator/rig/modbus_frames.h"

#include <algorithm>
#include <iterator>

namespace raywalk::capture {
namespace {

// Longer than the specified 3.5 characters at any common baud rate (4 ms at 9600), and than the
// pauses within one write on a busy machine.
constexpr std::chrono::milliseconds kSilence(10);
constexpr std::size_t kLongestRtuFrame = 256;
constexpr std::size_t kMbapBytes = 7;

}  // namespace

std::uint16_t modbus_crc(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xffff;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0xa001U : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

ModbusBytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  ModbusBytes frame(pdu.size() + 3);
  frame[0] = unit;
  std::copy(pdu.begin(), pdu.end(), frame.begin() + 1);
  const std::uint16_t crc = modbus_crc(std::span(frame).first(pdu.size() + 1));
  frame[pdu.size() + 1] = static_cast<std::uint8_t>(crc & 0xff);
  frame[pdu.size() + 2] = static_cast<std::uint8_t>(crc >> 8);
  return frame;
}

ModbusBytes tcp_frame(std::uint16_t transaction, std::uint8_t unit,
                      std::span<const std::uint8_t> pdu) {
  const std::size_t length = pdu.size() + 1;
  ModbusBytes frame(kMbapBytes + pdu.size());  // bytes 2 and 3, the protocol, stay 0
  frame[0] = static_cast<std::uint8_t>(transaction >> 8);
  frame[1] = static_cast<std::uint8_t>(transaction & 0xff);
  frame[4] = static_cast<std::uint8_t>(length >> 8);
  frame[5] = static_cast<std::uint8_t>(length & 0xff);
  frame[6] = unit;
  std::copy(pdu.begin(), pdu.end(), frame.begin() + kMbapBytes);
  return frame;
}

void RtuReceiver::add(std::span<const std::uint8_t> bytes, Time now) {
  if (now - last_byte_ > kSilence) {
    buffer_.clear();
    out_of_sync_ = false;
  }
  last_byte_ = now;
  if (!out_of_sync_) std::copy(bytes.begin(), bytes.end(), std::back_inserter(buffer_));
}

// Length of the frame in the buffer; 0 if not known yet. Requests with an address and a count or
// value have 8 bytes; the two that write several values hold their byte count in the seventh byte.
// For any other function, which is refused, the whole buffer is the frame.
std::size_t RtuReceiver::frame_length() const {
  if (buffer_.size() < 4) return 0;
  const int function = buffer_[1];
  if (function >= 1 && function <= 6) return 8;
  if (function == 15 || function == 16) return buffer_.size() < 7 ? 0 : 9U + buffer_[6];
  return std::min(buffer_.size(), kLongestRtuFrame);
}

std::optional<ModbusRequest> RtuReceiver::next() {
  const std::size_t length = frame_length();
  if (length == 0 || buffer_.size() < length) return std::nullopt;
  const std::span<const std::uint8_t> frame(buffer_.data(), length);
  const auto body = frame.first(length - 2);
  const unsigned sent_crc = frame[length - 2] | (frame[length - 1] << 8U);
  if (modbus_crc(body) != sent_crc) {
    buffer_.clear();
    out_of_sync_ = true;
    return std::nullopt;
  }
  ModbusRequest request{0, body[0], ModbusBytes(body.begin() + 1, body.end())};
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(length));
  return request;
}

void TcpReceiver::add(std::span<const std::uint8_t> bytes) {
  std::copy(bytes.begin(), bytes.end(), std::back_inserter(buffer_));
}

std::optional<ModbusRequest> TcpReceiver::next() {
  if (broken_ || buffer_.size() < kMbapBytes) return std::nullopt;
  // The length includes the unit and the PDU of at most 253 bytes.
  const std::size_t length = word_at(buffer_, 4);
  if (word_at(buffer_, 2) != 0 || length < 2 || length > 254) {
    broken_ = true;
    return std::nullopt;
  }
  const std::size_t end = kMbapBytes - 1 + length;
  if (buffer_.size() < end) return std::nullopt;
  const auto pdu_end = buffer_.begin() + static_cast<std::ptrdiff_t>(end);
  ModbusRequest request{word_at(buffer_, 0), buffer_[6],
                        ModbusBytes(buffer_.begin() + kMbapBytes, pdu_end)};
  buffer_.erase(buffer_.begin(), pdu_end);
  return request;
}

}  // namespace raywalk::capture
