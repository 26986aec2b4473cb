#include "simulator/rig/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/base/units.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/jpeg.h"
#include "core/files/shipped_configs.h"
#include "simulator/room/truth.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The target is rounded to whole steps, so it may differ slightly from the station.
constexpr double kSamePlace_mm = 0.1;

capture::CaptureConfig capture_of(const RigConfig& config) {
  std::error_code error;
  if (!fs::is_regular_file(config.capture_config, error)) {
    throw UsageError("'capture_config' " +
                     missing_config_text(config.capture_config, ConfigKind::kCapture));
  }
  capture::CaptureConfig capture = capture::read_capture_config(config.capture_config);
  capture::require_devices(capture);
  return capture;
}

// The room is built around the capture grid.
VirtualRoomSettings room_settings(const RigConfig& config, const capture::CaptureConfig& capture,
                                  const CapturePlan& plan) {
  VirtualRoomSettings settings = config.scene;
  settings.grid.cell_side_m = capture.grid.cell_side_m;
  settings.grid.cells_x = capture.grid.cells_x;
  settings.grid.cells_z = capture.grid.cells_z;
  settings.grid.spacing_mm = capture.grid.spacing_mm;
  settings.grid.overhang_share = plan.overhang_m / capture.grid.cell_side_m;
  return settings;
}

SimulatedCameraSettings camera_settings(const RigCameraSettings& rig, PanoramaSize frame,
                                        const fs::path& card) {
  SimulatedCameraSettings settings;
  settings.card_directory = card;
  settings.card_bytes = std::llround(1e6 * rig.card_mb);
  // About half a byte per pixel at common JPEG qualities.
  settings.typical_picture_bytes =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(frame.width) * frame.height / 2);
  settings.frame = frame;
  settings.exposure_ms = rig.exposure_ms;
  settings.clock_offset_s = rig.clock_offset_s;
  settings.automatic_wander_ev = rig.automatic_wander_ev;
  return settings;
}

PanoramaSize truth_size(const RigConfig& config) {
  const int width = config.truth.width_px > 0 ? config.truth.width_px : config.camera.width_px;
  return {width, width / 2};
}

json range_of(const Extremes& extremes) {
  return extremes.any ? json{extremes.low_mm, extremes.high_mm} : json(nullptr);
}

bool is_near(const CameraPose& a, const CameraPose& b, double within_mm) {
  // A hundredth of a pixel in a panorama 16384 wide. Poses of different lines that cross differ
  // more.
  constexpr double kSameAttitude_rad = 4e-6;
  return kMillimetresPerMetre * (a.position_m - b.position_m).norm() <= within_mm &&
         std::abs(a.attitude.yaw_rad - b.attitude.yaw_rad) <= kSameAttitude_rad &&
         std::abs(a.attitude.pitch_rad - b.attitude.pitch_rad) <= kSameAttitude_rad &&
         std::abs(a.attitude.roll_rad - b.attitude.roll_rad) <= kSameAttitude_rad;
}

}  // namespace

Rig::Rig(const RigConfig& config, const fs::path& directory, Clock* clock)
    : config_(config),
      capture_(capture_of(config)),
      directory_(directory),
      plan_(capture::plan_capture(capture_)),
      placements_(capture::placements_of(plan_)),
      frame_{config.camera.width_px, config.camera.width_px / 2},
      room_(room_settings(config, capture_, plan_)),
      rail_(config.rail, plan_, {config.slider.low_switch_mm, config.slider.high_switch_mm}),
      optics_(config.camera, frame_, config.dolly, -room_.extent().min_m.y(), config.scene.seed),
      line_(plan_.lines.front().id),
      faults_(clock, config.link),
      drive_(config.slider, clock, &faults_),
      camera_(camera_settings(config.camera, frame_, directory / "card"), clock, &faults_,
              [this](const ExposureNow& exposure) { return take_picture(exposure); }) {
  for (const Fault& fault : config.faults) add_fault(fault);
  begin_truth();
  drive_.on_move([this](double target_mm) { move_commanded(target_mm); });
  osc_.emplace(&camera_, &faults_, config.camera.port, endpoints());
  modbus_.emplace(DriveServerSettings{capture_.slider.unit, slider_device(), config.tcp_port},
                  capture::read_register_map(capture_.slider.register_map), &drive_, &faults_);
}

// Stops the servers before the devices that they use are destroyed.
Rig::~Rig() {
  modbus_.reset();
  osc_.reset();
}

void Rig::add_fault(const Fault& fault) {
  const auto is_its_station = [&fault](const CaptureStation& station) {
    return station.name == fault.at_station;
  };
  const bool is_in_plan =
      fault.at_station.empty() ||
      std::any_of(placements_.begin(), placements_.end(), [&](const CaptureLine& placement) {
        return std::any_of(placement.stations.begin(), placement.stations.end(), is_its_station);
      });
  if (!is_in_plan) {
    throw UsageError(fmt::format("fault '{}': the plan has no station {}", name_of(fault.kind),
                                 excerpt(fault.at_station)));
  }
  faults_.add(fault);
}

void Rig::move_commanded(double target_mm) {
  const std::string placed_at = line();
  if (config_.camera.render_ahead_within_mm > 0.0) {
    const CameraPose pose = rail_.carriage_pose(placed_at, target_mm, Duration::max());
    const std::lock_guard lock(mutex_);
    // What is not complete yet is kept, as releasing it would wait for it.
    std::erase_if(ahead_, [](const RenderedAhead& ahead) {
      return ahead.image.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    ahead_.push_back({pose, std::async(std::launch::async, [this, pose] {
                              return optics_.scene(room_, pose);
                            }).share()});
  }
  for (const CaptureLine& placement : placements_) {
    if (capture::placement_id(placement) != placed_at) continue;
    for (const CaptureStation& station : placement.stations) {
      if (std::abs(station.rail_mm - target_mm) <= kSamePlace_mm) {
        faults_.move_commanded(station.name);
      }
    }
  }
}

std::map<std::string, OscServer::Handler> Rig::endpoints() {
  const auto placed = [this](const std::string& body) {
    const json request = json::parse(body, nullptr, false);
    const bool is_valid = request.is_object() && request.value("line", json()).is_string() &&
                          request.value("placement", json(1)).is_number_integer();
    if (!is_valid) {
      throw Error("the request must be a JSON object with a 'line': " + excerpt(body));
    }
    CaptureLine placement;
    placement.id = request["line"].get<std::string>();
    placement.placement = request.value("placement", 1);
    place(capture::placement_id(placement));
    return state().dump();
  };
  const auto failing = [this](const std::string& body) {
    Fault fault;
    fault_schema(&fault).parse(body, "request");  // JSON is YAML
    add_fault(fault);
    return state().dump();
  };
  const auto mended = [this](const std::string&) {
    faults_.clear();
    drive_.reset_alarm();
    camera_.restart();
    return state().dump();
  };
  return {{"/rig/state", [this](const std::string&) { return state().dump(); }},
          {"/rig/place", placed},
          {"/rig/fault", failing},
          {"/rig/mend", mended}};
}

void Rig::place(const std::string& line_id) {
  if (!rail_.has_line(line_id)) {
    throw Error(fmt::format("the plan has no line {}", excerpt(line_id)));
  }
  if (drive_.state().moving) {
    throw Error("the carriage is moving; stop it before placing the rail at another line");
  }
  const std::lock_guard lock(mutex_);
  line_ = line_id;
}

std::string Rig::line() const {
  const std::lock_guard lock(mutex_);
  return line_;
}

// What the camera sees. What was rendered ahead serves if it is near enough; its pose is then the
// true one.
cv::Mat Rig::scene_from(CameraPose* pose) {
  std::unique_lock lock(mutex_);
  const RenderedAhead ahead = ahead_.empty() ? RenderedAhead{} : ahead_.back();
  lock.unlock();
  const double within_mm = config_.camera.render_ahead_within_mm;
  if (!ahead.image.valid() || !is_near(ahead.pose, *pose, within_mm)) {
    return optics_.scene(room_, *pose);
  }
  *pose = ahead.pose;
  return ahead.image.get();
}

std::string Rig::take_picture(const ExposureNow& exposure) {
  const std::string placed_at = line();
  const DriveTruth slider = drive_.truth();
  CameraPose pose = rail_.carriage_pose(placed_at, slider.carriage_mm, slider.still_for);
  const cv::Mat scene = scene_from(&pose);
  const auto jpeg = encode_jpeg(optics_.picture(scene, exposure), config_.camera.jpeg_quality);
  record_truth(exposure, placed_at, pose);
  return {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()};
}

void Rig::begin_truth() {
  const fs::path truth = directory_ / "truth";
  make_directories(truth / "dist");
  make_directories(truth / "gt");
  const fs::path table = truth / "true_poses.csv";
  std::error_code none_yet;
  const auto bytes = fs::file_size(table, none_yet);
  true_poses_.open(table, std::ios::app);
  if (none_yet || bytes == 0) true_poses_ << "file,line,x,y,z,yaw,pitch,roll\n" << std::flush;
  if (!true_poses_) throw Error("cannot write " + table.string());
  if (config_.truth.views == 0) return;
  Progress progress("rendering true views", config_.truth.views, "views");
  write_truth_views(room_, truth_viewpoints(room_, config_.truth.views), truth_size(config_), truth,
                    false, &progress);
}

void Rig::record_truth(const ExposureNow& exposure, const std::string& placed_at,
                       const CameraPose& pose) {
  const fs::path truth = directory_ / "truth";
  true_poses_ << fmt::format("{},{},{}\n", exposure.camera_name, placed_at, pose_fields(pose))
              << std::flush;
  if (!true_poses_) throw Error("cannot write " + (truth / "true_poses.csv").string());
  const auto every = static_cast<std::uint64_t>(config_.truth.distance_every);
  if (every == 0 || (exposure.number - 1) % every != 0) return;
  const std::string stem = fs::path(exposure.camera_name).stem().string();
  write_distance_map(room_, pose, truth_size(config_), truth / "dist" / (stem + ".png"));
}

json Rig::state() {
  const DriveState drive = drive_.state();
  const DriveTruth slider = drive_.truth();
  return {{"line", line()},
          {"carriage_mm", slider.carriage_mm},
          {"moving", drive.moving},
          {"homed", drive.homed},
          {"alarm_code", drive.alarm_code},
          {"commanded_mm", range_of(slider.commanded)},
          {"visited_mm", range_of(slider.visited)},
          {"moves", slider.moves},
          {"requests", faults_.exchanges()},
          {"pictures", camera_.pictures_taken()},
          {"faults", faults_.occurred()}};
}

}  // namespace raywalk::simulator
