#include "capture/slider/modbus_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "capture/base/device_fault.h"
#include "capture/base/word_of.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// Doubles with each consecutive failure: a busy drive needs a few milliseconds, a replugged adapter
// about a second until udev has created its name.
constexpr double kFirstPause_ms = 100.0;
// Exception 8 ("memory parity error"): Leadshine's drives answer so to a request with a wrong
// checksum (CS2RS manual, 4.4.1), which they have not executed.
constexpr int kDamagedRequest = EMBXMEMPAR;
// The line must become silent within this many reply times.
constexpr int kPatienceInReplyTimes = 4;

enum class Outcome {
  kDone,
  kUnanswered,  // no reply or only a damaged one before the timeout
  kBroken,      // the connection is lost
  kBusy,        // the device did not execute the request and asks to repeat it
  kRefused      // the device rejects the request
};

Outcome outcome_of(int error) {
  switch (error) {
    case EMBXSBUSY:
    case kDamagedRequest:
      return Outcome::kBusy;
    case EMBXILFUN:
    case EMBXILADD:
    case EMBXILVAL:
    case EMBXSFAIL:
    case EMBXNACK:
    case EMBXGPATH:
      return Outcome::kRefused;
    case ETIMEDOUT:
    case EMBXACK:   // accepted, perhaps executed later
    case EMBXGTAR:  // a gateway got no answer
    case EMBBADCRC:
    case EMBBADDATA:
    case EMBBADEXC:
    case EMBUNKEXC:
    case EMBMDATA:
    case EMBBADSLAVE:
      return Outcome::kUnanswered;
    default:
      return Outcome::kBroken;  // EIO after a hang-up, ECONNRESET, EPIPE, ...
  }
}

DeviceFault no_contact(const std::string& what) { return {FaultKind::kNoContact, what}; }

DeviceFault in_use_fault(const std::string& device) {
  return no_contact(
      fmt::format("{} is in use by another program; end it (fuser {} names it)", device, device));
}

DeviceFault open_port_fault(const std::string& device, int error) {
  switch (error) {
    case EBUSY:
      return in_use_fault(device);
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return no_contact(
          fmt::format("{} does not exist; plug in the adapter and see /dev/serial/by-id", device));
    case EACCES:
      return no_contact(
          fmt::format("no permission for {}; add the user to the group dialout", device));
    default:
      return no_contact(
          fmt::format("cannot open {} ({}); check the adapter", device, std::strerror(error)));
  }
}

bool is_pseudo_terminal(int fd) {
  // Device numbers of the Linux kernel (Documentation/admin-guide/devices.txt).
  constexpr unsigned kFirstMajor = 136;
  constexpr unsigned kLastMajor = 143;
  struct stat status = {};
  if (fstat(fd, &status) != 0) return false;
  return major(status.st_rdev) >= kFirstMajor && major(status.st_rdev) <= kLastMajor;
}

// Exclusive use of a serial port: two masters on one line would corrupt each other's requests.
class PortLock {
 public:
  // Opens the port and locks it with flock, which cooperating programs respect (pyserial, picocom
  // and this one). refuse_others adds TIOCEXCL against all others. Throws DeviceFault kNoContact:
  // no such port, no permission, not a serial port, in use.
  explicit PortLock(const std::string& device)
      // O_NONBLOCK: without it, open waits for a modem's carrier.
      : fd_(open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (fd_ < 0) throw open_port_fault(device, errno);
    const bool is_serial = isatty(fd_) != 0;
    if (is_serial && flock(fd_, LOCK_EX | LOCK_NB) == 0) return;
    close(fd_);
    if (is_serial) throw in_use_fault(device);
    throw no_contact(fmt::format("{} is not a serial port; correct slider.device", device));
  }
  ~PortLock() { close(fd_); }
  PortLock(const PortLock&) = delete;
  PortLock& operator=(const PortLock&) = delete;

  // Makes every later open() of the port fail, except by root. Not done by the constructor, because
  // it would also refuse the second descriptor that libmodbus opens. A serial port loses the flag
  // when the last program closes it. A pseudo-terminal keeps it while its other side is open, so a
  // killed program would lock out its successor; there flock must suffice.
  void refuse_others() const {
    if (!is_pseudo_terminal(fd_)) ioctl(fd_, TIOCEXCL);
  }

 private:
  int fd_;
};

// Waits until bytes can be read or the line is closed, at most for the time given. Signals do not
// end the wait. Uses the machine's clock: bytes arrive in real time even if the carriage runs on
// simulated time.
bool has_input(int fd, Duration wait) {
  const SteadyTime end = std::chrono::steady_clock::now() + wait;
  pollfd line{fd, POLLIN, 0};
  for (;;) {
    const double left_ms = std::max(0.0, ms_from_duration(end - std::chrono::steady_clock::now()));
    const int ready = poll(&line, 1, static_cast<int>(std::ceil(left_ms)));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

// Reads and drops bytes from a non-blocking descriptor until none has arrived for `quiet`. Else
// why not: kUnanswered after `patience`, kBroken if the other end has closed.
Outcome wait_until_quiet(int fd, Duration quiet, Duration patience) {
  const SteadyTime end = std::chrono::steady_clock::now() + patience;
  std::array<std::uint8_t, 512> dropped{};
  while (has_input(fd, quiet)) {
    const ssize_t got = read(fd, dropped.data(), dropped.size());
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return Outcome::kBroken;
    if (std::chrono::steady_clock::now() >= end) return Outcome::kUnanswered;
  }
  return Outcome::kDone;
}

// The silence that ends a frame on a serial line: 3.5 characters of 11 bits, and 1.75 ms above
// 19200 baud (Modbus over serial line 1.02, 2.5.1.1).
Duration frame_gap(int baud) {
  return duration_from_ms(baud > 19200 ? 1.75 : 3.5 * 11.0 * 1000.0 / baud);
}

std::string how_to_reach(const SliderConfig& config) {
  return config.connection == SliderConnection::kTcp
             ? fmt::format("{}:{}", config.host, config.port)
             : config.device;
}

modbus_t* new_context(const SliderConfig& config) {
  if (config.connection == SliderConnection::kTcp) {
    return modbus_new_tcp_pi(config.host.c_str(), std::to_string(config.port).c_str());
  }
  return modbus_new_rtu(config.device.c_str(), config.baud,
                        word_of(config.parity, {"N", "E", "O"}).front(), 8, config.stop_bits);
}

void set_timeout(modbus_t* context, double ms,
                 int (*set)(modbus_t*, std::uint32_t seconds, std::uint32_t microseconds)) {
  const auto microseconds = static_cast<std::uint64_t>(std::max(1.0, std::round(ms * 1e3)));
  set(context, static_cast<std::uint32_t>(microseconds / 1000000),
      static_cast<std::uint32_t>(microseconds % 1000000));
}

}  // namespace

// How far a request got and its outcome.
struct ModbusLink::Attempt {
  Outcome outcome = Outcome::kDone;
  std::string reason{};  // for people; empty for kDone
  int error = 0;         // of libmodbus
  bool opened = true;
  bool sent = false;
};

// An open connection over a serial line (RTU) or TCP, through libmodbus.
class ModbusLink::Connection {
 public:
  // Opens the connection. Throws UsageError, and DeviceFault kNoContact.
  explicit Connection(const SliderConfig& config)
      : reply_time_(
            duration_from_ms(std::max(config.response_timeout_ms, config.byte_timeout_ms))) {
    const std::string where = how_to_reach(config);
    if (config.connection == SliderConnection::kRtu) {
      lock_.emplace(config.device);
      frame_gap_ = frame_gap(config.baud);
    }
    context_.reset(new_context(config));
    if (!context_ || modbus_set_slave(context(), config.unit) != 0) {
      throw UsageError(
          fmt::format("{}: {}; correct the slider's connection", where, modbus_strerror(errno)));
    }
    set_timeout(context(), config.response_timeout_ms, modbus_set_response_timeout);
    set_timeout(context(), config.byte_timeout_ms, modbus_set_byte_timeout);
    // MODBUS_ERROR_RECOVERY_LINK never returns after a terminal has hung up (libmodbus issues 39
    // and 217); recover() replaces it.
    modbus_set_error_recovery(context(), MODBUS_ERROR_RECOVERY_NONE);
    if (modbus_connect(context()) != 0) {
      throw no_contact(
          fmt::format("cannot connect to {} ({}); check that the drive has power, its "
                      "cable and its address",
                      where, modbus_strerror(errno)));
    }
    if (lock_) lock_->refuse_others();
    if (lock_ && config.rs485 && modbus_rtu_set_serial_mode(context(), MODBUS_RTU_RS485) != 0) {
      throw no_contact(
          fmt::format("{} cannot switch an RS-485 driver ({}); leave slider.rs485 out "
                      "if the adapter switches by itself",
                      where, modbus_strerror(errno)));
    }
  }

  modbus_t* context() const { return context_.get(); }

  // Waits until a request may be sent: on RTU after a frame gap of silence.
  Attempt before_request() {
    const Outcome outcome = wait_until_quiet(fd(), frame_gap_, kPatienceInReplyTimes * reply_time_);
    if (outcome == Outcome::kDone) return {};
    return {outcome, outcome == Outcome::kBroken
                         ? "the other end has closed the connection"
                         : "another device sends on the line without a pause"};
  }

  // After a failed exchange: waits until no reply can arrive any more. False if that cannot be
  // ensured; the connection must then be reopened.
  //
  // RTU replies do not name their request, so a late reply could be taken for the next one: waits
  // until the line has been silent for as long as a reply may take. A reply later than twice that
  // can still be taken for the reply to a request of the same shape; therefore Carriage acts on a
  // position only after several consecutive readings. TCP numbers its requests, but after a reply
  // with a wrong number libmodbus 3.1.6 stays out of sync with the stream, even after a flush: only
  // a new connection helps.
  bool recover(Outcome outcome) {
    if (outcome == Outcome::kBroken) return false;
    if (outcome != Outcome::kUnanswered) return true;
    return lock_ && wait_until_quiet(fd(), reply_time_, kPatienceInReplyTimes * reply_time_) ==
                        Outcome::kDone;
  }

  // Whether a serial adapter returns what is sent, as on a two-wire line whose receiver stays on:
  // the bytes of a request then come back, before any reply.
  bool echoes(int unit) {
    // The first register is read: function 3, address 0, 1 register.
    const std::array<std::uint8_t, 6> request{static_cast<std::uint8_t>(unit), 3, 0, 0, 0, 1};
    std::array<std::uint8_t, request.size()> seen{};
    if (!lock_ || before_request().outcome != Outcome::kDone) return false;
    if (modbus_send_raw_request(context(), request.data(), request.size()) < 0) return false;
    for (std::size_t count = 0; count < seen.size() && has_input(fd(), reply_time_);) {
      const ssize_t got = ::read(fd(), seen.data() + count, seen.size() - count);
      if (got <= 0) return false;
      count += static_cast<std::size_t>(got);
    }
    return seen == request;
  }

 private:
  struct Free {
    void operator()(modbus_t* context) const {
      modbus_close(context);
      modbus_free(context);
    }
  };
  int fd() const { return modbus_get_socket(context()); }

  std::optional<PortLock> lock_;  // of a serial port; outlives libmodbus's own descriptor
  std::unique_ptr<modbus_t, Free> context_;
  Duration frame_gap_{0};
  Duration reply_time_{0};  // a reply later than this counts as lost
};

ModbusLink::ModbusLink(const SliderConfig& config, Clock* clock) : config_(config), clock_(clock) {
  if (const auto impossible = impossible_connection(config)) {
    throw UsageError(impossible->key + " " + impossible->what);
  }
}

ModbusLink::~ModbusLink() = default;

std::string ModbusLink::description() const {
  return fmt::format("unit {} at {}", config_.unit, how_to_reach(config_));
}

std::vector<std::uint16_t> ModbusLink::read(RegisterKind kind, int address, int count) {
  const bool input = kind == RegisterKind::kInput;
  std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
  exchange(input ? 4 : 3, address, count, [&](modbus_t* context) {
    return (input ? modbus_read_input_registers : modbus_read_registers)(context, address, count,
                                                                         words.data());
  });
  return words;
}

bool ModbusLink::write(int address, std::span<const std::uint16_t> words) {
  const auto count = static_cast<int>(words.size());
  return exchange(count == 1 ? 6 : 16, address, count, [&](modbus_t* context) {
    return count == 1 ? modbus_write_register(context, address, words.front())
                      : modbus_write_registers(context, address, count, words.data());
  });
}

// Sends the request until it is answered. False: a write that may or may not have been executed.
bool ModbusLink::exchange(int function, int address, int count, const Request& request) {
  const bool is_write = function > 4;
  for (int failures = 0;;) {
    const Attempt last = attempt(count, request);
    if (last.outcome == Outcome::kDone) return true;
    require_not_refused(last, function, address);
    const bool surely_not_done = !last.sent || last.outcome == Outcome::kBusy;
    if (is_write && !surely_not_done) return false;
    if (++failures >= config_.tries) fail_without_contact(last);
    // Recovering from an unanswered read has taken its time.
    if (is_write || last.outcome != Outcome::kUnanswered) {
      clock_->sleep(duration_from_ms(kFirstPause_ms * (1 << std::min(failures - 1, 5))));
    }
  }
}

ModbusLink::Attempt ModbusLink::attempt(int count, const Request& request) {
  if (!connection_) {
    try {
      connection_ = std::make_unique<Connection>(config_);
      ++openings_;
    } catch (const DeviceFault& fault) {
      return {.outcome = Outcome::kBroken, .reason = fault.what(), .opened = false};
    }
  }
  Attempt attempt = connection_->before_request();
  if (attempt.outcome == Outcome::kDone) {
    attempt.sent = true;
    const int result = request(connection_->context());
    if (result == count) return attempt;
    attempt.error = result < 0 ? errno : EMBBADDATA;
    attempt.outcome = outcome_of(attempt.error);
    attempt.reason = modbus_strerror(attempt.error);
  }
  if (!connection_->recover(attempt.outcome)) connection_.reset();
  return attempt;
}

void ModbusLink::require_not_refused(const Attempt& attempt, int function, int address) const {
  if (attempt.outcome != Outcome::kRefused) return;
  if (attempt.error != EMBXILFUN) {
    throw DeviceFault(FaultKind::kWrongDevice,
                      fmt::format("{} refuses register 0x{:04x} ({}); check the register map and "
                                  "the unit against the drive",
                                  description(), address, attempt.reason));
  }
  const std::string other_kind =
      function > 4 ? "" : fmt::format("set input_registers to {} in its map, or ", function == 3);
  throw DeviceFault(
      FaultKind::kWrongDevice,
      fmt::format("{} answers, but does not know function {} of Modbus ({}); {}take a register map "
                  "made for this drive: its manual lists the functions that it knows",
                  description(), function, attempt.reason, other_kind));
}

void ModbusLink::fail_without_contact(const Attempt& last) {
  if (!last.opened) throw no_contact(last.reason);
  if (last.sent && connection_ && connection_->echoes(config_.unit)) {
    throw no_contact(fmt::format(
        "{} returns what is sent to it: the RS-485 adapter echoes, so no reply can be "
        "distinguished from a request; switch its echo off (its receiver must be off while it "
        "sends) or use another adapter",
        config_.device));
  }
  const char* settings =
      config_.connection == SliderConnection::kTcp ? "unit" : "unit, baud rate and parity";
  throw no_contact(
      fmt::format("{} does not answer ({}; tries: {}); check the drive's power, its "
                  "cable, {}",
                  description(), last.reason, config_.tries, settings));
}

}  // namespace raywalk::capture
