// Requests to a Modbus device that survive faults of the line: late, lost, damaged and duplicated
// replies, unplugged adapters, reset connections.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/base/clock.h"
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
  // How far a request got and its outcome.
  struct Attempt {
    bool opened = false;
    bool sent = false;
    Exchange exchange{};
  };
  class Connection;
  using Request = std::function<Exchange(Connection&)>;

  Attempt attempt(const Request& request);
  void open();
  void wait_before_retry(int failures);
  void require_not_refused(const Exchange& exchange, int address) const;
  [[noreturn]] void fail_without_contact(const Attempt& last) const;

  SliderConfig config_;
  Clock* clock_;
  std::unique_ptr<Connection> connection_;
  int openings_ = 0;
};

}  // namespace raywalk::capture
