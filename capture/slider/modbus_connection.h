// An open connection to a Modbus device over a serial line (RTU) or TCP, through libmodbus.
#pragma once

#include <modbus/modbus.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/slider/port_lock.h"
#include "capture/slider/register_link.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

enum class ExchangeOutcome {
  kDone,
  kUnanswered,  // no reply or only a damaged one before the timeout
  kBroken,      // the connection is lost
  kBusy,        // the device did not execute the request and asks to repeat it
  kRefused      // the device rejects the request
};

struct Exchange {
  ExchangeOutcome outcome = ExchangeOutcome::kDone;
  std::string reason{};  // for people; empty for kDone
};

// Throws UsageError for impossible settings: no device or host, a baud rate that libmodbus does not
// know (it would silently use 9600), an invalid unit or number of stop bits.
void check_connection_settings(const SliderConfig& config);

class ModbusConnection {
 public:
  // Opens the connection. Throws UsageError as above, and DeviceFault kNoContact.
  explicit ModbusConnection(const SliderConfig& config);
  ~ModbusConnection();
  ModbusConnection(const ModbusConnection&) = delete;
  ModbusConnection& operator=(const ModbusConnection&) = delete;

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

}  // namespace raywalk::capture
