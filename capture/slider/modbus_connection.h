// One open connection to a Modbus device, over a serial line (RTU) or TCP, by libmodbus.
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
  kUnanswered,  // nothing, or something damaged, came back in time
  kBroken,      // the connection is gone
  kBusy,        // the device asks to try again: it has not carried the request out
  kRefused      // the device will not do that
};

struct Exchange {
  ExchangeOutcome outcome = ExchangeOutcome::kDone;
  std::string reason{};  // of all but kDone, in words
};

// Throws UsageError for settings that no connection can have: a baud rate that libmodbus does not
// know (it would quietly take 9600 instead), a parity, a unit or a connection that does not exist.
void check_connection_settings(const SliderConfig& config);

class ModbusConnection {
 public:
  // Opens it. Throws DeviceFault kNoContact, saying what to check.
  explicit ModbusConnection(const SliderConfig& config);
  ~ModbusConnection();
  ModbusConnection(const ModbusConnection&) = delete;
  ModbusConnection& operator=(const ModbusConnection&) = delete;

  // One request each, sent once. `words` has its final size on entry.
  Exchange read(RegisterKind kind, int address, std::span<std::uint16_t> words);
  Exchange write(int address, std::span<const std::uint16_t> words);

  // Waits until the line is free for a request: for a frame gap (RTU) nothing must come in.
  Exchange before_request();
  // After an exchange that went wrong: waits until no reply can be under way any more. False where
  // that cannot be known, and the connection has to be opened anew.
  bool recover(ExchangeOutcome outcome);

 private:
  struct Free {
    void operator()(modbus_t* context) const;
  };
  bool is_serial() const { return lock_.has_value(); }
  void set_timeouts(const SliderConfig& config);
  void connect(const SliderConfig& config);
  void switch_to_rs485(const std::string& device);

  std::optional<PortLock> lock_;  // of a serial port; held longer than libmodbus's own descriptor
  std::unique_ptr<modbus_t, Free> context_;
  Duration frame_gap_{0};
  Duration reply_time_{0};  // a reply that has not come by then has been lost
};

}  // namespace raywalk::capture
