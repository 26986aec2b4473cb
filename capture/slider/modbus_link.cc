#include "capture/slider/modbus_link.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/base/device_fault.h"

namespace raywalk::capture {
namespace {

// Doubles with each consecutive failure: a busy drive needs a few milliseconds, a replugged adapter
// about a second until udev has created its name.
constexpr double kFirstPause_ms = 100.0;

}  // namespace

ModbusLink::ModbusLink(const SliderConfig& config, Clock* clock) : config_(config), clock_(clock) {
  check_connection_settings(config);
}

std::string ModbusLink::description() const {
  return config_.connection == SliderConnection::kTcp
             ? fmt::format("unit {} at {}:{}", config_.unit, config_.host, config_.port)
             : fmt::format("unit {} at {}", config_.unit, config_.device);
}

std::vector<std::uint16_t> ModbusLink::read(RegisterKind kind, int address, int count) {
  std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
  for (int failures = 0;;) {
    const Attempt last = attempt(
        [&](ModbusConnection& connection) { return connection.read(kind, address, words); });
    if (last.exchange.outcome == ExchangeOutcome::kDone) return words;
    require_not_refused(last.exchange, address);
    if (++failures >= config_.tries) fail_without_contact(last);
    if (last.exchange.outcome != ExchangeOutcome::kUnanswered) wait_before_retry(failures);
  }
}

bool ModbusLink::write(int address, std::span<const std::uint16_t> words) {
  for (int failures = 0;;) {
    const Attempt last =
        attempt([&](ModbusConnection& connection) { return connection.write(address, words); });
    if (last.exchange.outcome == ExchangeOutcome::kDone) return true;
    require_not_refused(last.exchange, address);
    const bool surely_not_done = !last.sent || last.exchange.outcome == ExchangeOutcome::kBusy;
    if (!surely_not_done) return false;
    if (++failures >= config_.tries) fail_without_contact(last);
    wait_before_retry(failures);
  }
}

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
  connection_.emplace(config_);
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
