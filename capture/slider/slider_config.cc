#include "capture/slider/slider_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace raywalk::capture {
namespace {

// The rates that libmodbus 3.1.6 supports. It silently replaces any other by 9600.
constexpr std::array kBaudRates{
    300,    600,    1200,   2400,   4800,    9600,    19200,   38400,   57600,   115200,  230400,
    460800, 500000, 576000, 921600, 1000000, 1152000, 1500000, 2500000, 3000000, 3500000, 4000000};
// 0 is for broadcasts, 248 to 255 are reserved (Modbus over serial line 1.02, 2.2); TCP devices
// other than gateways answer to 255 (Modbus messaging on TCP 1.0b, 4.4.2.1).
constexpr int kLastUnit = 247;
constexpr int kTcpDevice = 255;

}  // namespace

std::optional<ImpossibleSetting> impossible_connection(const SliderConfig& config) {
  const bool serial = config.connection == SliderConnection::kRtu;
  if (serial && config.device.empty()) {
    return {
        {"slider.device", "is missing; name the serial port, preferably as /dev/serial/by-id/..."}};
  }
  if (!serial && config.host.empty()) {
    return {{"slider.host", "is missing; name the drive's address"}};
  }
  const bool device_itself = !serial && config.unit == kTcpDevice;
  if ((config.unit < 1 || config.unit > kLastUnit) && !device_itself) {
    return {
        {"slider.unit", fmt::format("is {}; it must lie between 1 and {}, or be {} on the network",
                                    config.unit, kLastUnit, kTcpDevice)}};
  }
  if (!serial) return std::nullopt;
  if (std::ranges::find(kBaudRates, config.baud) == kBaudRates.end()) {
    return {{"slider.baud",
             fmt::format("is {}; known rates are {}", config.baud, fmt::join(kBaudRates, ", "))}};
  }
  if (config.stop_bits != 1 && config.stop_bits != 2) {
    return {{"slider.stop_bits", fmt::format("is {}; it must be 1 or 2", config.stop_bits)}};
  }
  return std::nullopt;
}

}  // namespace raywalk::capture
