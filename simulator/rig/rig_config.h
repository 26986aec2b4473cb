// Configuration of the simulated rig. configs/simulated-rig.yaml documents every key with its
// default.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/camera/camera_config.h"
#include "core/files/settings.h"
#include "simulator/rig/faults.h"
#include "simulator/rig/rail.h"
#include "simulator/rig/simulated_drive.h"
#include "simulator/room/room_settings.h"
#include "simulator/room/sensor.h"

namespace raywalk::simulator {

using capture::FrameKind;

struct RigCameraSettings {
  int port = 0;  // 0: any free port
  FrameKind layout = FrameKind::kPanorama;
  std::filesystem::path lens{};  // of dual-fisheye frames; empty: simple_dual_fisheye
  LensLightSettings light{};     // likewise
  int width_px = 1024;           // of a frame, a multiple of 4; it is half as high
  int jpeg_quality = 95;
  double render_ahead_within_mm = 0.0;  // of the expected pose; 0: never
  double exposure_ms = 200.0;
  double clock_offset_s = 0.0;
  double card_mb = 32000.0;
  double automatic_wander_ev = 0.3;
  double exposure_drift_ev = 0.0;  // amplitude of a slow drift, also of locked exposure
  SensorSettings sensor{};
};

// The dolly under the camera, visible in all of its pictures.
struct DollySettings {
  bool visible = false;
  // Angle from the nadir at which the middle of the platform's edges is seen, 10 to 45; corners and
  // wheels extend further. Below 10 the pole would extend beyond the platform.
  double reach_deg = 20.0;
};

struct RigTruthSettings {
  int distance_every = 0;  // distance map for every n-th picture; 0: none
  int width_px = 0;        // of distance maps and views, a multiple of 4; 0: the camera's
  int views = 0;           // number of true views from inside the cells
};

struct RigConfig {
  std::filesystem::path capture_config{};  // defines the lines and the drive's registers
  VirtualRoomSettings scene{};             // its grid is taken from the capture plan
  DriveSettings slider{};
  int tcp_port = 0;  // of Modbus TCP; 0: any free port
  RailSettings rail{};
  LinkSettings link{};
  RigCameraSettings camera{};
  DollySettings dolly{};
  std::vector<Fault> faults{};
  RigTruthSettings truth{};
};

// The schema of all keys, bound to `config`, which must outlive it. Faults of a file are appended
// to those of `config`.
SettingsSchema rig_schema(RigConfig* config);

// Reads the file; `capture_config` and `camera.lens` become relative to the current directory.
// Throws UsageError as SettingsSchema does, if capture_config is missing, or if values contradict
// each other.
RigConfig read_rig_config(const std::filesystem::path& file);

}  // namespace raywalk::simulator
