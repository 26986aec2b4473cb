// The slider section of a configuration. configs/capture-*.yaml explain every key.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "capture/base/word_of.h"
#include "capture/slider/carriage.h"

namespace raywalk::capture {

// Modbus over a serial line, or over TCP.
enum class SliderConnection { kRtu, kTcp };
inline constexpr std::array kSliderConnections{SliderConnection::kRtu, SliderConnection::kTcp};

enum class SerialParity { kNone, kEven, kOdd };
inline constexpr std::array kSerialParities{SerialParity::kNone, SerialParity::kEven,
                                            SerialParity::kOdd};

// The words of the configuration file.
constexpr std::string_view name_of(SliderConnection connection) {
  return word_of(connection, {"rtu", "tcp"});
}
constexpr std::string_view name_of(SerialParity parity) {
  return word_of(parity, {"none", "even", "odd"});
}

struct SliderConfig {
  SliderConnection connection = SliderConnection::kRtu;
  std::string device;  // serial port, preferably /dev/serial/by-id/...
  int baud = 115200;
  SerialParity parity = SerialParity::kNone;
  int stop_bits = 1;
  bool rs485 = false;  // the kernel switches the driver of an RS-485 port
  std::string host;    // for tcp
  int port = 502;
  int unit = 1;  // Modbus address, 1 to 247; on TCP also 255
  double response_timeout_ms = 600.0;
  double byte_timeout_ms = 500.0;
  int tries = 3;  // of one request, at least 1
  std::filesystem::path register_map;
  double low_limit_mm = 0.0;  // soft limits
  double high_limit_mm = 0.0;
  double first_station_mm = 0.0;  // position of the first station of every line on the rail
  int placements_per_line = 1;    // of the rail, at most: lines longer than the rail need several
  MotionRules motion{};
};

struct ImpossibleSetting {
  std::string key{};   // "slider.host"
  std::string what{};  // "is missing; name the drive's address"
};

// The first setting of the connection that cannot be; none if all can.
std::optional<ImpossibleSetting> impossible_connection(const SliderConfig& config);

}  // namespace raywalk::capture
