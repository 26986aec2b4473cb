// Access to the registers of one Modbus device, over a serial line (RTU) or TCP. Requests survive
// faults of the line: late, lost, damaged and duplicated replies, unplugged adapters, reset
// connections.
#pragma once

#include <modbus/modbus.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

enum class RegisterKind { kHolding, kInput };

class RegisterLink {
 public:
  virtual ~RegisterLink() = default;

  // "unit 1 at /dev/ttyUSB0"
  virtual std::string description() const = 0;
  // How often the connection has been opened. After a change, another device may be connected.
  virtual int openings() const = 0;
  // The words of `count` registers (1 to 125). Repeats the request until the reply is complete.
  // Throws DeviceFault: kNoContact after the last try, kWrongDevice if the device refuses.
  virtual std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) = 0;
  // Sends a write of 1 to 123 words once. False: it was sent without a complete reply, so it may or
  // may not have been executed; the caller must find out. Throws DeviceFault kNoContact if it was
  // certainly not executed (no connection, device busy throughout), kWrongDevice if the device
  // refuses it.
  virtual bool write(int address, std::span<const std::uint16_t> words) = 0;
};

// A reply is not taken for the reply to another request, as far as the protocol allows:
//  - before each request, received bytes are dropped and the line has been silent for a frame gap,
//    which removes duplicated replies;
//  - after a request without a complete reply, RTU waits until the line has been silent for as long
//    as a reply may take, and TCP opens a new connection;
//  - a duplicate of the last reply that arrives between a request and its reply is rejected by its
//    shape (unit, function and length; on TCP also its number), unless both requests have the same
//    shape. In that case the reading is one poll old. So ModbusSlider reads status and position in
//    one request where the drive allows it, and Carriage does not act on a single reading.
class ModbusLink final : public RegisterLink {
 public:
  // Opens no connection yet. Throws UsageError for an impossible_connection(). Pauses before a
  // connection is reopened use the clock, which must outlive the link.
  ModbusLink(const SliderConfig& config, Clock* clock);
  ~ModbusLink() override;

  std::string description() const override;
  int openings() const override { return openings_; }
  std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) override;
  bool write(int address, std::span<const std::uint16_t> words) override;

 private:
  class Connection;
  struct Attempt;
  // Sends one request, once; the number of its registers, or -1 and an error of libmodbus in errno.
  using Request = std::function<int(modbus_t* context)>;

  bool exchange(int function, int address, int count, const Request& request);
  Attempt attempt(int count, const Request& request);
  void require_not_refused(const Attempt& attempt, int function, int address) const;
  [[noreturn]] void fail_without_contact(const Attempt& last);

  SliderConfig config_;
  Clock* clock_;
  std::unique_ptr<Connection> connection_;
  int openings_ = 0;
};

}  // namespace raywalk::capture
