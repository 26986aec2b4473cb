// For tests: a Modbus device on a pseudo-terminal or on TCP. It answers correctly unless the test's
// script replaces its replies.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace raywalk::capture {

// Once both sides of a terminal are closed, the kernel reuses its number. A link that reconnects
// after a hang-up would then reach the device of another test. While this object holds the terminal
// open, such a link finds it closed.
class TerminalReservation {
 public:
  explicit TerminalReservation(const std::string& device)
      : terminal_(open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {}
  ~TerminalReservation() {
    if (terminal_ >= 0) close(terminal_);
  }
  TerminalReservation(const TerminalReservation&) = delete;
  TerminalReservation& operator=(const TerminalReservation&) = delete;

 private:
  int terminal_;
};

using Bytes = std::vector<std::uint8_t>;

// Bytes that the peer sends `after_ms` after the request.
struct TimedReply {
  int after_ms = 0;
  Bytes frame;
};

class TestModbusPeer {
 public:
  enum class Line { kSerial, kTcp };
  // What is sent instead of `reply`, the correct reply to request n (from 0), in order of time.
  using Script = std::function<std::vector<TimedReply>(int n, const Bytes& reply)>;

  TestModbusPeer(Line line, Script script) : line_(line), script_(std::move(script)) {
    if (line == Line::kSerial) {
      open_terminal();
    } else {
      open_listener();
    }
    thread_ = std::thread([this] { serve(); });
  }
  ~TestModbusPeer() {
    over_ = true;
    thread_.join();
    for (const int fd : {terminal_, listener_, connection_}) {
      if (fd >= 0) close(fd);
    }
  }
  TestModbusPeer(const TestModbusPeer&) = delete;
  TestModbusPeer& operator=(const TestModbusPeer&) = delete;

  const std::string& device() const { return device_; }
  int port() const { return port_; }
  int requests() const { return requests_; }
  int connections() const { return connections_; }

  // The frame that is being answered, for the script.
  const Bytes& request() const { return request_; }

  std::uint16_t value(int address) {
    const std::lock_guard lock(mutex_);
    return registers_[address];
  }
  void set(int address, std::uint16_t value) {
    const std::lock_guard lock(mutex_);
    registers_[address] = value;
  }
  // Closes the line; it is closed when this returns.
  void hang_up() {
    hang_up_ = true;
    while (hang_up_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  // The frame on this line of a body of unit, function and data.
  Bytes framed(Bytes body, const Bytes& request) const {
    if (line_ == Line::kSerial) {
      const std::uint16_t sum = checksum(body);
      body.push_back(static_cast<std::uint8_t>(sum & 0xff));
      body.push_back(static_cast<std::uint8_t>(sum >> 8));
      return body;
    }
    Bytes frame{request[0], request[1], 0, 0, 0, static_cast<std::uint8_t>(body.size())};
    frame.insert(frame.end(), body.begin(), body.end());
    return frame;
  }

 private:
  // CRC-16 with the polynomial 0xA001, from 0xFFFF (Modbus over serial line 1.02, 6.2.2).
  static std::uint16_t checksum(const Bytes& bytes) {
    std::uint16_t sum = 0xffff;
    for (const std::uint8_t byte : bytes) {
      sum = static_cast<std::uint16_t>(sum ^ byte);
      for (int bit = 0; bit < 8; ++bit) {
        sum = static_cast<std::uint16_t>((sum & 1) != 0 ? (sum >> 1) ^ 0xa001 : sum >> 1);
      }
    }
    return sum;
  }

  void open_terminal() {
    terminal_ = posix_openpt(O_RDWR | O_NOCTTY);
    if (terminal_ < 0 || grantpt(terminal_) != 0 || unlockpt(terminal_) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    device_ = ptsname(terminal_);
    reservation_.emplace(device_);
  }
  void open_listener() {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(listener_, 4) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no listener");
    }
    port_ = ntohs(address.sin_port);
  }

  static bool readable(int fd) {
    pollfd ready{fd, POLLIN, 0};
    return poll(&ready, 1, 5) > 0 && (ready.revents & POLLIN) != 0;
  }
  int stream() const { return line_ == Line::kSerial ? terminal_ : connection_; }

  void serve() {
    while (!over_) {
      if (hang_up_) {
        drop_line();
        hang_up_ = false;
      }
      if (listener_ >= 0 && readable(listener_)) accept_connection();
      if (stream() >= 0 && readable(stream())) take_bytes();
    }
  }
  void drop_line() {
    close(stream());
    (line_ == Line::kSerial ? terminal_ : connection_) = -1;
  }
  void accept_connection() {
    if (connection_ >= 0) close(connection_);
    connection_ = accept(listener_, nullptr, nullptr);
    incoming_.clear();
    ++connections_;
  }

  void take_bytes() {
    std::uint8_t buffer[256];
    const ssize_t got = read(stream(), buffer, sizeof(buffer));
    if (got <= 0) {
      if (line_ == Line::kTcp) drop_line();
      return;
    }
    incoming_.insert(incoming_.end(), buffer, buffer + got);
    const std::size_t header = line_ == Line::kSerial ? 0 : 6;
    const std::size_t check = line_ == Line::kSerial ? 2 : 0;
    const bool writes_block = incoming_.size() > header + 6 && incoming_[header + 1] == 16;
    const std::size_t body = writes_block ? 7u + incoming_[header + 6] : 6u;
    if (incoming_.size() < header + body + check) return;
    request_ = std::exchange(incoming_, {});
    answer(request_, header);
  }

  void answer(const Bytes& request, std::size_t header) {
    const auto byte = [&](std::size_t i) { return request[header + i]; };
    const int address = byte(2) << 8 | byte(3);
    const int second = byte(4) << 8 | byte(5);
    Bytes body{byte(0), byte(1)};
    std::unique_lock lock(mutex_);
    if (byte(1) == 3 || byte(1) == 4) {
      body.push_back(static_cast<std::uint8_t>(2 * second));
      for (int i = 0; i < second; ++i) {
        const std::uint16_t value = registers_[address + i];
        body.push_back(static_cast<std::uint8_t>(value >> 8));
        body.push_back(static_cast<std::uint8_t>(value & 0xff));
      }
    } else {
      for (int i = 0; byte(1) == 16 && i < second; ++i) {
        const std::size_t at = 7 + 2 * static_cast<std::size_t>(i);
        registers_[address + i] = static_cast<std::uint16_t>(byte(at) << 8 | byte(at + 1));
      }
      if (byte(1) == 6) registers_[address] = static_cast<std::uint16_t>(second);
      for (std::size_t i = 2; i < 6; ++i) body.push_back(byte(i));
    }
    lock.unlock();
    const auto now = std::chrono::steady_clock::now();
    for (const TimedReply& reply : script_(requests_++, framed(body, request))) {
      std::this_thread::sleep_until(now + std::chrono::milliseconds(reply.after_ms));
      if (over_) return;
      if (line_ == Line::kTcp) {
        send(connection_, reply.frame.data(), reply.frame.size(), MSG_NOSIGNAL);
      } else if (write(terminal_, reply.frame.data(), reply.frame.size()) < 0) {
        return;
      }
    }
  }

  Line line_;
  Script script_;
  int terminal_ = -1;
  int listener_ = -1;
  int connection_ = -1;
  std::string device_;
  std::optional<TerminalReservation> reservation_;
  int port_ = 0;
  std::mutex mutex_;
  std::map<int, std::uint16_t> registers_;
  Bytes incoming_;
  Bytes request_;
  std::atomic<int> requests_{0};
  std::atomic<int> connections_{0};
  std::atomic<bool> hang_up_{false};
  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace raywalk::capture
