// What a user says of the slider. configs/capture-*.yaml explain every key.
#pragma once

#include <filesystem>
#include <string>

#include "capture/slider/carriage.h"

namespace raywalk::capture {

struct SliderConfig {
  std::string connection = "rtu";  // "rtu" or "tcp"
  std::string device;              // serial port; best by /dev/serial/by-id
  int baud = 115200;
  std::string parity = "none";  // "none", "even" or "odd"
  int stop_bits = 1;
  bool rs485 = false;  // have the kernel switch the driver of an RS-485 port
  std::string host;    // for tcp
  int port = 502;
  int unit = 1;  // Modbus address, 1 to 247; on TCP also 255
  double response_timeout_ms = 600.0;
  double byte_timeout_ms = 500.0;
  int tries = 3;  // of one request, at least 1
  std::filesystem::path register_map;
  double low_limit_mm = 0.0;  // soft limits
  double high_limit_mm = 0.0;
  double first_station_mm = 0.0;  // where on the rail the first station of every line lies
  MotionRules motion{};
};

}  // namespace raywalk::capture
