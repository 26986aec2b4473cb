// Requests to a Modbus device that outlast what goes wrong on a line: late, lost, damaged and
// doubled replies, unplugged adapters, reset connections.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/slider/modbus_connection.h"
#include "capture/slider/register_link.h"
#include "capture/slider/slider_config.h"

namespace raywalk::capture {

// A reply is never taken for one to another request, as far as the protocol lets that be told:
//  - before each request, what has come in is dropped, and the line has been silent for a frame
//    gap; so a reply that came twice is gone by then;
//  - after a request without a whole answer, RTU waits until the line has been silent for as long
//    as a reply may take, and TCP opens a new connection;
//  - a second copy of the last reply that comes in between a request and its answer is refused by
//    its shape (unit, function and length; on TCP also its number) unless both requests have the
//    same. Then it is one request old: a position from one poll ago, a status from one poll ago.
//    So ModbusSlider reads status and position in one request where the drive lets it, and Carriage
//    takes no single reading for the truth.
class ModbusLink final : public RegisterLink {
 public:
  // Opens nothing yet. Throws UsageError for settings that no connection can have. The clock has to
  // outlive it; pauses before opening anew pass on it.
  ModbusLink(const SliderConfig& config, Clock* clock);

  std::string description() const override;
  int openings() const override { return openings_; }
  std::vector<std::uint16_t> read(RegisterKind kind, int address, int count) override;
  bool write(int address, std::span<const std::uint16_t> words) override;

 private:
  // How far a request got, and how it ended.
  struct Attempt {
    bool opened = false;
    bool sent = false;
    Exchange exchange{};
  };
  using Request = std::function<Exchange(ModbusConnection&)>;

  Attempt attempt(const Request& request);
  void open();
  void wait_before_retry(int failures);
  void require_not_refused(const Exchange& exchange, int address) const;
  [[noreturn]] void fail_without_contact(const Attempt& last) const;

  SliderConfig config_;
  Clock* clock_;
  std::optional<ModbusConnection> connection_;
  int openings_ = 0;
};

}  // namespace raywalk::capture
