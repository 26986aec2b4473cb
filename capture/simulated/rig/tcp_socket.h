// Sockets of a server on loopback that never block.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "capture/simulated/rig/link_faults.h"

namespace raywalk::capture {

class TcpSocket {
 public:
  // On 127.0.0.1; port 0 takes one that is free. Throws Error naming the port where it is taken.
  static TcpSocket listen_on_loopback(int port);
  ~TcpSocket();
  TcpSocket(TcpSocket&& other) noexcept;
  TcpSocket& operator=(TcpSocket&& other) = delete;
  TcpSocket(const TcpSocket&) = delete;
  TcpSocket& operator=(const TcpSocket&) = delete;

  int descriptor() const { return descriptor_; }
  int port() const;
  // The next client, if one has come.
  std::optional<TcpSocket> accept() const;
  // What has come; empty if nothing yet, none once the client is gone.
  std::optional<ModbusBytes> read();
  // What does not fit, as nobody reads, is lost.
  void write(std::span<const std::uint8_t> bytes);
  // Has the client see a reset (ECONNRESET) rather than an end.
  void reset_connection();

 private:
  explicit TcpSocket(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace raywalk::capture
