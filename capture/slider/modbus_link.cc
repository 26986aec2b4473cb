#include "capture/slider/modbus_link.h"

#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <optional>

#include "capture/base/device_fault.h"
#include "capture/base/word_of.h"
#include "capture/slider/serial_line.h"
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

struct Timeout {
  std::uint32_t seconds;
  std::uint32_t microseconds;
};

Timeout timeout_from_ms(double ms) {
  const auto microseconds = static_cast<std::uint64_t>(std::max(1.0, std::round(ms * 1e3)));
  return {static_cast<std::uint32_t>(microseconds / 1000000),
          static_cast<std::uint32_t>(microseconds % 1000000)};
}

modbus_t* new_context(const SliderConfig& config) {
  if (config.connection == SliderConnection::kTcp) {
    return modbus_new_tcp_pi(config.host.c_str(), std::to_string(config.port).c_str());
  }
  return modbus_new_rtu(config.device.c_str(), config.baud,
                        word_of(config.parity, {"N", "E", "O"}).front(), 8, config.stop_bits);
}

ExchangeOutcome outcome_of(int error) {
  switch (error) {
    case EMBXSBUSY:
    case kDamagedRequest:
      return ExchangeOutcome::kBusy;
    case EMBXILFUN:
    case EMBXILADD:
    case EMBXILVAL:
    case EMBXSFAIL:
    case EMBXNACK:
    case EMBXGPATH:
      return ExchangeOutcome::kRefused;
    case ETIMEDOUT:
    case EMBXACK:   // accepted, perhaps executed later
    case EMBXGTAR:  // a gateway got no answer
    case EMBBADCRC:
    case EMBBADDATA:
    case EMBBADEXC:
    case EMBUNKEXC:
    case EMBMDATA:
    case EMBBADSLAVE:
      return ExchangeOutcome::kUnanswered;
    default:
      return ExchangeOutcome::kBroken;  // EIO after a hang-up, ECONNRESET, EPIPE, ...
  }
}

Exchange exchange_of(int result, std::size_t words) {
  if (result == static_cast<int>(words)) return {};
  const int error = result < 0 ? errno : EMBBADDATA;
  return {outcome_of(error), modbus_strerror(error)};
}

std::string how_to_reach(const SliderConfig& config) {
  return config.connection == SliderConnection::kTcp
             ? fmt::format("{}:{}", config.host, config.port)
             : config.device;
}

}  // namespace

// An open connection over a serial line (RTU) or TCP, through libmodbus.
class ModbusLink::Connection {
 public:
  // Opens the connection. Throws UsageError, and DeviceFault kNoContact.
  explicit Connection(const SliderConfig& config);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Sends one request, once. `words` of a read has one element per register.
  Exchange read(RegisterKind kind, int address, std::span<std::uint16_t> words);
  Exchange write(int address, std::span<const std::uint16_t> words);

  // Waits until a request may be sent: on RTU after a frame gap of silence.
  Exchange before_request();
  // After a failed exchange: waits until no reply can arrive any more. False if that cannot be
  // ensured; the connection must then be reopened.
  bool recover(ExchangeOutcome outcome);

 private:
  struct Free {
    void operator()(modbus_t* context) const;
  };
  bool is_serial() const { return lock_.has_value(); }
  void set_timeouts(const SliderConfig& config);
  void connect(const SliderConfig& config);
  void switch_to_rs485(const std::string& device);

  std::optional<PortLock> lock_;  // of a serial port; outlives libmodbus's own descriptor
  std::unique_ptr<modbus_t, Free> context_;
  Duration frame_gap_{0};
  Duration reply_time_{0};  // a reply later than this counts as lost
};

void ModbusLink::Connection::Free::operator()(modbus_t* context) const {
  modbus_close(context);
  modbus_free(context);
}

ModbusLink::Connection::Connection(const SliderConfig& config)
    : reply_time_(duration_from_ms(std::max(config.response_timeout_ms, config.byte_timeout_ms))) {
  if (config.connection == SliderConnection::kRtu) {
    lock_.emplace(config.device);
    frame_gap_ = frame_gap(config.baud);
  }
  context_.reset(new_context(config));
  if (!context_ || modbus_set_slave(context_.get(), config.unit) != 0) {
    throw UsageError(fmt::format("{}: {}; correct the slider's connection", how_to_reach(config),
                                 modbus_strerror(errno)));
  }
  set_timeouts(config);
  connect(config);
}

ModbusLink::Connection::~Connection() = default;

void ModbusLink::Connection::set_timeouts(const SliderConfig& config) {
  const Timeout response = timeout_from_ms(config.response_timeout_ms);
  const Timeout byte = timeout_from_ms(config.byte_timeout_ms);
  modbus_set_response_timeout(context_.get(), response.seconds, response.microseconds);
  modbus_set_byte_timeout(context_.get(), byte.seconds, byte.microseconds);
  // MODBUS_ERROR_RECOVERY_LINK never returns after a terminal has hung up (libmodbus issues 39 and
  // 217); recover() replaces it.
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
}

void ModbusLink::Connection::connect(const SliderConfig& config) {
  if (modbus_connect(context_.get()) != 0) {
    throw DeviceFault(
        FaultKind::kNoContact,
        fmt::format("cannot connect to {} ({}); check that the drive has power, its cable and its "
                    "address",
                    how_to_reach(config), modbus_strerror(errno)));
  }
  if (!is_serial()) return;
  lock_->refuse_others();
  if (config.rs485) switch_to_rs485(config.device);
}

void ModbusLink::Connection::switch_to_rs485(const std::string& device) {
  if (modbus_rtu_set_serial_mode(context_.get(), MODBUS_RTU_RS485) != 0) {
    throw DeviceFault(FaultKind::kNoContact,
                      fmt::format("{} cannot switch an RS-485 driver ({}); leave slider.rs485 out "
                                  "if the adapter switches by itself",
                                  device, modbus_strerror(errno)));
  }
}

Exchange ModbusLink::Connection::read(RegisterKind kind, int address,
                                      std::span<std::uint16_t> words) {
  const auto read_registers =
      kind == RegisterKind::kInput ? modbus_read_input_registers : modbus_read_registers;
  return exchange_of(
      read_registers(context_.get(), address, static_cast<int>(words.size()), words.data()),
      words.size());
}

Exchange ModbusLink::Connection::write(int address, std::span<const std::uint16_t> words) {
  const int written = words.size() == 1
                          ? modbus_write_register(context_.get(), address, words.front())
                          : modbus_write_registers(context_.get(), address,
                                                   static_cast<int>(words.size()), words.data());
  return exchange_of(written, words.size());
}

Exchange ModbusLink::Connection::before_request() {
  switch (wait_until_quiet(modbus_get_socket(context_.get()), frame_gap_,
                           kPatienceInReplyTimes * reply_time_)) {
    case LineState::kQuiet:
      return {};
    case LineState::kNeverQuiet:
      return {ExchangeOutcome::kUnanswered, "another device sends on the line without a pause"};
    case LineState::kGone:
      break;
  }
  return {ExchangeOutcome::kBroken, "the other end has closed the connection"};
}

// RTU replies do not name their request, so a late reply could be taken for the next one: waits
// until the line has been silent for as long as a reply may take. A reply later than twice that can
// still be taken for the reply to a request of the same shape; therefore Carriage acts on a
// position only after several consecutive readings. TCP numbers its requests, but after a reply
// with a wrong number libmodbus 3.1.6 stays out of sync with the stream, even after a flush: only a
// new connection helps.
bool ModbusLink::Connection::recover(ExchangeOutcome outcome) {
  if (outcome == ExchangeOutcome::kBroken) return false;
  const bool answered = outcome != ExchangeOutcome::kUnanswered;
  if (answered) return true;
  if (!is_serial()) return false;
  return wait_until_quiet(modbus_get_socket(context_.get()), reply_time_,
                          kPatienceInReplyTimes * reply_time_) == LineState::kQuiet;
}

ModbusLink::ModbusLink(const SliderConfig& config, Clock* clock) : config_(config), clock_(clock) {
  if (const auto impossible = impossible_connection(config)) {
    throw UsageError(impossible->key + " " + impossible->what);
  }
}

std::string ModbusLink::description() const {
  return config_.connection == SliderConnection::kTcp
             ? fmt::format("unit {} at {}:{}", config_.unit, config_.host, config_.port)
             : fmt::format("unit {} at {}", config_.unit, config_.device);
}

std::vector<std::uint16_t> ModbusLink::read(RegisterKind kind, int address, int count) {
  std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
  for (int failures = 0;;) {
    const Attempt last =
        attempt([&](Connection& connection) { return connection.read(kind, address, words); });
    if (last.exchange.outcome == ExchangeOutcome::kDone) return words;
    require_not_refused(last.exchange, address);
    if (++failures >= config_.tries) fail_without_contact(last);
    if (last.exchange.outcome != ExchangeOutcome::kUnanswered) wait_before_retry(failures);
  }
}

bool ModbusLink::write(int address, std::span<const std::uint16_t> words) {
  for (int failures = 0;;) {
    const Attempt last =
        attempt([&](Connection& connection) { return connection.write(address, words); });
    if (last.exchange.outcome == ExchangeOutcome::kDone) return true;
    require_not_refused(last.exchange, address);
    const bool surely_not_done = !last.sent || last.exchange.outcome == ExchangeOutcome::kBusy;
    if (!surely_not_done) return false;
    if (++failures >= config_.tries) fail_without_contact(last);
    wait_before_retry(failures);
  }
}

ModbusLink::~ModbusLink() = default;

ModbusLink::Attempt ModbusLink::attempt(const Request& request) {
  if (!connection_) {
    try {
      open();
    } catch (const DeviceFault& fault) {
      return {false, false, {ExchangeOutcome::kBroken, fault.what()}};
    }
  }
  Attempt attempt{true, false, connection_->before_request()};
  if (attempt.exchange.outcome == ExchangeOutcome::kDone) {
    attempt = {true, true, request(*connection_)};
  }
  if (attempt.exchange.outcome != ExchangeOutcome::kDone &&
      !connection_->recover(attempt.exchange.outcome)) {
    connection_.reset();
  }
  return attempt;
}

void ModbusLink::open() {
  connection_ = std::make_unique<Connection>(config_);
  ++openings_;
}

void ModbusLink::wait_before_retry(int failures) {
  clock_->sleep(duration_from_ms(kFirstPause_ms * (1 << std::min(failures - 1, 5))));
}

void ModbusLink::require_not_refused(const Exchange& exchange, int address) const {
  if (exchange.outcome != ExchangeOutcome::kRefused) return;
  throw DeviceFault(FaultKind::kWrongDevice,
                    fmt::format("{} refuses register 0x{:04x} ({}); check the register map and the "
                                "unit against the drive",
                                description(), address, exchange.reason));
}

void ModbusLink::fail_without_contact(const Attempt& last) const {
  const std::string& reason = last.exchange.reason;
  if (!last.opened) throw DeviceFault(FaultKind::kNoContact, reason);
  const char* settings =
      config_.connection == SliderConnection::kTcp ? "unit" : "unit, baud rate and parity";
  throw DeviceFault(FaultKind::kNoContact,
                    fmt::format("{} does not answer ({}; tries: {}); check the drive's power, its "
                                "cable, {}",
                                description(), reason, config_.tries, settings));
}

}  // namespace raywalk::capture
