#include "capture/slider/modbus_connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <stdexcept>

#include "capture/base/device_fault.h"
#include "capture/slider/quiet_line.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

// The rates that libmodbus 3.1.6 supports. It silently replaces any other by 9600.
constexpr std::array kBaudRates{
    300,    600,    1200,   2400,   4800,    9600,    19200,   38400,   57600,   115200,  230400,
    460800, 500000, 576000, 921600, 1000000, 1152000, 1500000, 2500000, 3000000, 3500000, 4000000};
// 0 is for broadcasts, 248 to 255 are reserved (Modbus over serial line 1.02, 2.2); TCP devices
// other than gateways answer to 255 (Modbus messaging on TCP 1.0b, 4.4.2.1).
constexpr int kLastUnit = 247;
// Exception 8 ("memory parity error"): Leadshine's drives answer so to a request with a wrong
// checksum (CS2RS manual, 4.4.1), which they have not executed.
constexpr int kDamagedRequest = EMBXMEMPAR;
// The line must become silent within this many reply times.
constexpr int kPatienceInReplyTimes = 4;

// As modbus_new_rtu takes it.
char parity_letter(SerialParity parity) {
  switch (parity) {
    case SerialParity::kNone:
      return 'N';
    case SerialParity::kEven:
      return 'E';
    case SerialParity::kOdd:
      return 'O';
  }
  throw std::logic_error("unknown parity");
}

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
  return modbus_new_rtu(config.device.c_str(), config.baud, parity_letter(config.parity), 8,
                        config.stop_bits);
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

void check_connection_settings(const SliderConfig& config) {
  const bool device_itself =
      config.connection == SliderConnection::kTcp && config.unit == MODBUS_TCP_SLAVE;
  if ((config.unit < 1 || config.unit > kLastUnit) && !device_itself) {
    throw UsageError(fmt::format("slider.unit is {}; Modbus units are 1 to {}, and on TCP also {}",
                                 config.unit, kLastUnit, MODBUS_TCP_SLAVE));
  }
  if (config.connection == SliderConnection::kTcp) {
    if (config.host.empty()) throw UsageError("slider.host is missing; a tcp slider needs it");
    return;
  }
  if (config.device.empty()) throw UsageError("slider.device is missing; an rtu slider needs it");
  if (std::find(kBaudRates.begin(), kBaudRates.end(), config.baud) == kBaudRates.end()) {
    throw UsageError(fmt::format("slider.baud is {}; known rates are {}", config.baud,
                                 fmt::join(kBaudRates, ", ")));
  }
  if (config.stop_bits != 1 && config.stop_bits != 2) {
    throw UsageError(fmt::format("slider.stop_bits is {}; it must be 1 or 2", config.stop_bits));
  }
}

void ModbusConnection::Free::operator()(modbus_t* context) const {
  modbus_close(context);
  modbus_free(context);
}

ModbusConnection::ModbusConnection(const SliderConfig& config)
    : reply_time_(duration_from_ms(std::max(config.response_timeout_ms, config.byte_timeout_ms))) {
  check_connection_settings(config);
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

ModbusConnection::~ModbusConnection() = default;

void ModbusConnection::set_timeouts(const SliderConfig& config) {
  const Timeout response = timeout_from_ms(config.response_timeout_ms);
  const Timeout byte = timeout_from_ms(config.byte_timeout_ms);
  modbus_set_response_timeout(context_.get(), response.seconds, response.microseconds);
  modbus_set_byte_timeout(context_.get(), byte.seconds, byte.microseconds);
  // MODBUS_ERROR_RECOVERY_LINK never returns after a terminal has hung up (libmodbus issues 39 and
  // 217); recover() replaces it.
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
}

void ModbusConnection::connect(const SliderConfig& config) {
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

void ModbusConnection::switch_to_rs485(const std::string& device) {
  if (modbus_rtu_set_serial_mode(context_.get(), MODBUS_RTU_RS485) != 0) {
    throw DeviceFault(FaultKind::kNoContact,
                      fmt::format("{} cannot switch an RS-485 driver ({}); leave slider.rs485 out "
                                  "if the adapter switches by itself",
                                  device, modbus_strerror(errno)));
  }
}

Exchange ModbusConnection::read(RegisterKind kind, int address, std::span<std::uint16_t> words) {
  const auto read_registers =
      kind == RegisterKind::kInput ? modbus_read_input_registers : modbus_read_registers;
  return exchange_of(
      read_registers(context_.get(), address, static_cast<int>(words.size()), words.data()),
      words.size());
}

Exchange ModbusConnection::write(int address, std::span<const std::uint16_t> words) {
  const int written = words.size() == 1
                          ? modbus_write_register(context_.get(), address, words.front())
                          : modbus_write_registers(context_.get(), address,
                                                   static_cast<int>(words.size()), words.data());
  return exchange_of(written, words.size());
}

Exchange ModbusConnection::before_request() {
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
bool ModbusConnection::recover(ExchangeOutcome outcome) {
  if (outcome == ExchangeOutcome::kBroken) return false;
  const bool answered = outcome != ExchangeOutcome::kUnanswered;
  if (answered) return true;
  if (!is_serial()) return false;
  return wait_until_quiet(modbus_get_socket(context_.get()), reply_time_,
                          kPatienceInReplyTimes * reply_time_) == LineState::kQuiet;
}

}  // namespace raywalk::capture
