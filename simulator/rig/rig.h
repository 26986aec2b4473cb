// The simulated rig: a drive on Modbus, a rail with placement errors, and a camera with the Open
// Spherical Camera API that takes pictures of a virtual room.
#pragma once

#include <filesystem>
#include <fstream>
#include <future>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "simulator/rig/drive_server.h"
#include "simulator/rig/faults.h"
#include "simulator/rig/osc_server.h"
#include "simulator/rig/rail.h"
#include "simulator/rig/rig_config.h"
#include "simulator/rig/rig_optics.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {

// Runs from construction to destruction. Files in its directory:
//   slider   symbolic link to the pseudo-terminal of Modbus RTU
//   card/    the camera's card
//   truth/true_poses.csv      file,line,x,y,z,yaw,pitch,roll (metres, degrees) of every picture,
//                             `file` being its name on the card; appended to an existing table
//   truth/dist/<picture>.png  distance maps, as in write_capture.h
//   truth/gt, gt.csv, dist    true views from inside the cells (write_truth_views)
// The rail is initially at the plan's first line.
//
// In addition to the camera's API, its HTTP server has these endpoints (JSON):
//   POST /rig/place {"line": "x0"}   places the rail at that line; other keys are ignored, as the
//                                    capture's run.place_url sends more
//   POST /rig/fault {"kind": "stall", "for_ms": 2000}   adds a fault, with the keys of the
//                                    configuration's `faults`; without a trigger it begins at once
//   POST /rig/mend                   ends all faults
//   GET  /rig/state                  returns state(), as do the other three
class Rig {
 public:
  // Creates the directory if missing, furnishes the room and writes the true views, which takes
  // seconds. `clock` must outlive the rig; the network uses the system clock. Throws UsageError for
  // an invalid configuration (see read_capture_config, plan_capture, read_register_map,
  // VirtualRoom, RigOptics), Error if a port or the directory cannot be used.
  Rig(const RigConfig& config, const std::filesystem::path& directory, Clock* clock);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  std::filesystem::path slider_device() const { return directory_ / "slider"; }
  int modbus_port() const { return modbus_->tcp_port(); }
  std::string camera_url() const { return osc_->url(); }

  SimulatedDrive& drive() { return drive_; }
  SimulatedCamera& camera() { return camera_; }

  // Throws Error if the plan does not have the line or the carriage is moving.
  void place(const std::string& line_id);
  std::string line() const;

  // {"line", "carriage_mm" (true), "moving", "homed", "alarm_code",
  //  "commanded_mm": [lowest, highest] or null, "visited_mm": [lowest, highest] since homing,
  //  "moves", "requests" (Modbus), "pictures", "faults" (that occurred)}
  nlohmann::json state();

 private:
  // What the camera will see at the end of a move, rendered while the carriage is on its way.
  struct RenderedAhead {
    CameraPose pose{};
    std::shared_future<cv::Mat> image{};
  };

  void add_fault(const Fault& fault);
  void move_commanded(double target_mm);
  cv::Mat scene_from(CameraPose* pose);
  std::string take_picture(const ExposureNow& exposure);
  void begin_truth();
  void record_truth(const ExposureNow& exposure, const std::string& placed_at,
                    const CameraPose& pose);
  std::map<std::string, OscServer::Handler> endpoints();

  const RigConfig config_;
  const capture::CaptureConfig capture_;
  const std::filesystem::path directory_;
  const CapturePlan plan_;
  const std::vector<CaptureLine> placements_;  // of its lines
  const PanoramaSize frame_;
  const VirtualRoom room_;
  const Rail rail_;
  const RigOptics optics_;
  std::ofstream true_poses_;
  mutable std::mutex mutex_;  // of the next two
  std::string line_;
  std::vector<RenderedAhead> ahead_;
  Faults faults_;
  SimulatedDrive drive_;
  SimulatedCamera camera_;
  std::optional<OscServer> osc_;
  std::optional<DriveServer> modbus_;
};

}  // namespace raywalk::simulator
