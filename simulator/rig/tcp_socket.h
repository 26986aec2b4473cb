// Non-blocking TCP server sockets on loopback.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "simulator/rig/link_faults.h"

namespace raywalk::capture {

class TcpSocket {
 public:
  // Listens on 127.0.0.1; port 0 chooses a free one. Throws Error naming the port if it is in use.
  static TcpSocket listen_on_loopback(int port);
  ~TcpSocket();
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) = delete;
  TcpSocket(const TcpSocket&) = delete;
  TcpSocket& operator=(const TcpSocket&) = delete;

  int descriptor() const { return descriptor_; }
  int port() const;
  // The next waiting client, if any.
  std::optional<TcpSocket> accept() const;
  // The received bytes, possibly none; nullopt once the client has disconnected.
  std::optional<ModbusBytes> read();
  // Bytes that do not fit the send buffer are lost.
  void write(std::span<const std::uint8_t> bytes);
  // Closes such that the client sees a reset (ECONNRESET) rather than end of file.
  void reset_connection();

 private:
  explicit TcpSocket(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace raywalk::capture
