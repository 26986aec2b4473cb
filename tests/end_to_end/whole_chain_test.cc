// The whole chain as a user runs it: a session of a simulated rig, calibrated, packed, with
// estimated distances, and its views compared with what the camera saw inside the cell.
// RAYWALK_CAPTURE, RAYWALK_CALIBRATE, RAYWALK_BUILD_LF and RAYWALK_RENDER are the programs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "core/files/csv.h"
#include "core/files/sqlite_connection.h"
#include "core/geometry/sphere.h"
#include "tests/end_to_end/run_command.h"
#include "tests/end_to_end/simulated_rig_process.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Four lines of 13 stations and one to compare with; pictures of two fisheyes with the errors of
// configs/rehearsal-rig.yaml, half as wide.
constexpr const char* kCapture = R"(
grid: {{spacing_mm: 100, overhang_mm: 100}}
validation:
  - {{axis: x, across_m: 0.1, from_m: -0.45, to_m: 0.45, spacing_mm: 150}}
slider:
  device: none
  register_map: {0}/sliders/leadshine-pr0.yaml
  response_timeout_ms: 200
  byte_timeout_ms: 50
  high_limit_mm: 2100
  first_station_mm: 20
  motion: {{speed_mm_s: 4000, acceleration_mm_s2: 40000, settle_ms: 20, poll_ms: 5}}
camera:
  frames: dual-fisheye
  width_px: 568
  height_px: 284
  osc: {{url: "http://127.0.0.1", poll_ms: 5}}
run: {{least_free_mb: 1}}
)";
constexpr const char* kRig = R"(
capture_config: capture.yaml
slider: {{max_speed_mm_s: 5000, max_acceleration_mm_s2: 50000, homing_speed_mm_s: 2000, high_switch_mm: 2200}}
rail:
  placing_spread_mm: 5.5
  direction_spread_deg: 0.5
  tilt_spread_deg: 0.3
  attitude_spread_deg: 0.45
  sag_mm: 1
  bow_mm: 0.8
  twist_deg: 0.2
  jitter_mm: 1
  jitter_deg: 0.1
  vibration_mm: 0
camera:
  layout: dual-fisheye
  lens: {0}/lenses/simulated.yaml
  width_px: 568
  vignetting: 0.25
  lens_gain_ev: 0.1
  exposure_ms: 5
  exposure_drift_ev: 0.05
  noise_levels: 1
  shot_noise: 0.02
dolly: {{visible: true}}
)";

struct Pose {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
};

Pose pose_of(const Eigen::Vector3d& position_m, double yaw_deg, double pitch_deg, double roll_deg) {
  return {position_m,
          world_from_camera({radians_from_degrees(yaw_deg), radians_from_degrees(pitch_deg),
                             radians_from_degrees(roll_deg)})};
}

// By how much the second pose, seen from the first, is displaced from where it truly is.
double relative_error_mm(const Pose& a, const Pose& b, const Pose& true_a, const Pose& true_b) {
  const auto seen = [](const Pose& from, const Pose& to) {
    return Eigen::Vector3d(from.world_from_camera.transpose() * (to.position_m - from.position_m));
  };
  return 1e3 * (seen(a, b) - seen(true_a, true_b)).norm();
}

class WholeChainTest : public ::testing::Test {
 protected:
  WholeChainTest() {
    write_file_atomically(directory_ / "capture.yaml", fmt::format(kCapture, RAYWALK_CONFIGS));
    write_file_atomically(directory_ / "rig.yaml", fmt::format(kRig, RAYWALK_CONFIGS));
  }

  static void run(const std::string& command) {
    const CommandResult result = run_command(command);
    ASSERT_EQ(result.exit_code, 0) << command << "\n" << result.output << result.errors;
  }
  std::string path(const char* name) const { return (directory_ / name).string(); }

  // By the name of their station.
  std::map<std::string, Pose> estimated_poses() const {
    std::map<std::string, Pose> poses;
    const json document = calibration()["poses"];
    for (const json& frame : document["frames"]) {
      const auto at = frame["position_m"].get<std::array<double, 3>>();
      poses[frame["name"]] = pose_of(Eigen::Vector3d(at[0], at[1], at[2]), frame["yaw_deg"],
                                     frame["pitch_deg"], frame["roll_deg"]);
    }
    return poses;
  }
  std::map<std::string, Pose> true_poses() const {
    const std::map<std::string, std::string> stations = stations_of_pictures();
    const CsvTable table =
        CsvTable::read(directory_ / "rig/truth/true_poses.csv",
                       {"file", "line", "x", "y", "z", "yaw", "pitch", "roll"}, {});
    std::map<std::string, Pose> poses;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const auto station = stations.find(table.text(row, "file"));
      if (station == stations.end()) continue;  // taken to meter the light
      poses[station->second] =
          pose_of({table.number(row, "x"), table.number(row, "y"), table.number(row, "z")},
                  table.number(row, "yaw"), table.number(row, "pitch"), table.number(row, "roll"));
    }
    return poses;
  }
  json calibration() const {
    return json::parse(read_file(directory_ / "calibration/calibration.json"));
  }
  // For report_browser_test, which opens them.
  void keep_reports() const {
    for (const std::string name : {"calibration", "report"}) {
      const fs::path kept = fs::path(RAYWALK_KEPT_REPORTS) / name;
      fs::create_directories(kept);
      fs::copy_file(directory_ / name / "index.html", kept / "index.html",
                    fs::copy_options::overwrite_existing);
    }
  }

 private:
  std::map<std::string, std::string> stations_of_pictures() const {
    SqliteConnection session(directory_ / "session/session.db", SqliteAccess::kReadOnly);
    SqliteStatement frames(
        &session,
        "SELECT frame.camera_name, station.name FROM frame "
        "JOIN attempt ON attempt.id = frame.attempt_id AND attempt.outcome = 'captured' "
        "JOIN station ON station.id = attempt.station_id");
    std::map<std::string, std::string> stations;
    while (frames.step()) stations[frames.text(0)] = frames.text(1);
    return stations;
  }

 protected:
  TestDirectory directory_;
};

TEST_F(WholeChainTest, FromTheFirstMoveToValidatedViews) {
  {
    const SimulatedRigProcess rig({.directory = directory_.path()});
    ASSERT_NO_FATAL_FAILURE(
        run(fmt::format("{} run {} --rig {} --session {}", RAYWALK_CAPTURE, path("capture.yaml"),
                        rig.directory().string(), path("session"))));
  }
  ASSERT_NO_FATAL_FAILURE(run(fmt::format(
      "{} all {} --out {} --lens-start {}/lenses/dual-fisheye.yaml --width 512 --auto-mask "
      "--keyframes-mm 200 --face-px 192 --pairs 12",
      RAYWALK_CALIBRATE, path("session"), path("calibration"), RAYWALK_CONFIGS)));
  EXPECT_EQ(calibration()["trustworthy"], true);
  EXPECT_TRUE(calibration()["mask"]["automatic"]["reach_deg"].is_number());

  // The two stations nearest to each intersection of the grid.
  const auto estimated = estimated_poses(), truth = true_poses();
  ASSERT_EQ(truth.size(), 4U * 13U + 7U);
  double worst_mm = 0.0;
  for (const auto& [x_station, z_station] :
       std::vector<std::pair<std::string, std::string>>{{"x0_001", "z0_001"},
                                                        {"x0_011", "z1_001"},
                                                        {"x1_001", "z0_011"},
                                                        {"x1_011", "z1_011"}}) {
    worst_mm =
        std::max(worst_mm, relative_error_mm(estimated.at(x_station), estimated.at(z_station),
                                             truth.at(x_station), truth.at(z_station)));
  }
  // Before calibration they are 13 to 27 mm off. Measured: 0.3 to 0.5 mm.
  EXPECT_LT(worst_mm, 1.0);

  ASSERT_NO_FATAL_FAILURE(run(fmt::format("{} pack --frames {} --out {}", RAYWALK_BUILD_LF,
                                          path("calibration/poses.csv"), path("room.lf"))));
  ASSERT_NO_FATAL_FAILURE(
      run(fmt::format("{} depth {} --width 256", RAYWALK_BUILD_LF, path("room.lf"))));
  ASSERT_NO_FATAL_FAILURE(run(
      fmt::format("{} validate {} --truth {} --method hlf-vd,two-sided --viewpoints 1 --report {}",
                  RAYWALK_RENDER, path("room.lf"), path("calibration/gt.csv"), path("report"))));
  keep_reports();
  const json modes = json::parse(read_file(directory_ / "report/metrics.json"))["modes"];
  // Measured: 28.5 and 29.8 dB.
  EXPECT_GT(modes[0]["psnr_db"], 27.5);
  EXPECT_GT(modes[1]["psnr_db"], 28.8);
}

}  // namespace
}  // namespace raywalk
