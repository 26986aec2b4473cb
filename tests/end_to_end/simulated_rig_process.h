// For tests: raywalk-simulate rig in a separate process, and its configuration files.
#pragma once

#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/files/atomic_output.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk {

// Configuration files of a session with a few fast stations in a small room.
struct RehearsalFiles {
  std::filesystem::path directory;
  double spacing_mm = 500.0;
  double settle_ms = 20.0;
  double speed_mm_s = 4000.0;
  double high_limit_mm = 2100.0;
  int placements_per_line = 1;
  std::string more_capture{};  // YAML appended to capture.yaml
  std::string more_rig{};      // YAML appended to rig.yaml

  std::filesystem::path capture() const { return directory / "capture.yaml"; }
  std::filesystem::path rig() const { return directory / "rig.yaml"; }

  void write() const {
    std::ofstream(capture()) << fmt::format(
        "grid:\n  spacing_mm: {}\n  overhang_mm: 0\n"
        "slider:\n  device: none\n  register_map: {}/sliders/leadshine-pr0.yaml\n"
        "  response_timeout_ms: 200\n  byte_timeout_ms: 50\n"
        "  high_limit_mm: {}\n  first_station_mm: 20\n  placements_per_line: {}\n"
        "  motion:\n    speed_mm_s: {}\n    acceleration_mm_s2: 40000\n    settle_ms: {}\n"
        "    poll_ms: 5\n    settle_timeout_ms: 2000\n"
        "camera:\n  width_px: 64\n  height_px: 32\n"
        "  osc:\n    url: http://127.0.0.1\n    poll_ms: 5\n    picture_timeout_ms: 3000\n"
        "    connect_timeout_ms: 2000\n"
        "run:\n  least_free_mb: 1\n{}",
        spacing_mm, RAYWALK_CONFIGS, high_limit_mm, placements_per_line, speed_mm_s, settle_ms,
        more_capture);
    std::ofstream(rig()) << fmt::format(
        "capture_config: capture.yaml\n"
        "slider:\n  max_speed_mm_s: 5000\n  max_acceleration_mm_s2: 50000\n"
        "  homing_speed_mm_s: 2000\n  high_switch_mm: 2200\n"
        "camera:\n  width_px: 64\n  exposure_ms: 5\n{}",
        more_rig);
  }
};

// A simulated rig that runs until destruction.
class SimulatedRigProcess {
 public:
  explicit SimulatedRigProcess(const RehearsalFiles& files)
      : directory_(files.directory / "rig"),
        process_({RAYWALK_SIMULATE, "rig", files.rig().string(), "--out", directory_.string()},
                 files.directory / "rig.log") {
    while (!std::filesystem::exists(directory_ / "rig.json")) {
      if (process_.has_ended()) {
        throw std::runtime_error(read_file(files.directory / "rig.log"));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ~SimulatedRigProcess() {
    process_.signal(SIGTERM);
    process_.wait();
  }

  const std::filesystem::path& directory() const { return directory_; }

 private:
  std::filesystem::path directory_;
  BackgroundProcess process_;
};

}  // namespace raywalk
