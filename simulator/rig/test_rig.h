// For tests: a small rig with an empty room, which is quick to furnish.
#pragma once

#include <filesystem>

#include "core/files/atomic_output.h"
#include "simulator/rig/rig_config.h"

namespace raywalk::simulator {

// Writes a capture's configuration of one cell of 1 m with five stations to a line, at 100, 350,
// ... 1100 mm on the rail, without overhang; returns a rig for it.
inline RigConfig small_rig(const std::filesystem::path& directory,
                           const std::filesystem::path& register_map) {
  write_file_atomically(directory / "capture.yaml",
                        "grid:\n  spacing_mm: 250\n  overhang_mm: 0\n"
                        "slider:\n  device: unused\n  register_map: " +
                            register_map.string() +
                            "\n  low_limit_mm: 0\n  high_limit_mm: 1200\n"
                            "  first_station_mm: 100\n"
                            "camera:\n  osc:\n    url: http://127.0.0.1:1\n");
  RigConfig config;
  config.capture_config = directory / "capture.yaml";
  config.scene.scene.file = "empty";
  config.slider.high_switch_mm = 1300.0;
  config.slider.backlash_mm = 0.0;
  config.camera.width_px = 64;
  config.camera.exposure_ms = 0.0;
  return config;
}

}  // namespace raywalk::simulator
