#include "simulator/rig/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/jpeg.h"
#include "core/files/shipped_configs.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Of one line; as many as a configuration may have.
constexpr double kMaxPlacements = 1000.0;

fs::path made(const fs::path& directory) {
  make_directories(directory);
  return directory;
}

CaptureConfig capture_of(const RigConfig& config) {
  std::error_code error;
  if (!fs::is_regular_file(config.capture_config, error)) {
    throw UsageError("'capture_config' " +
                     missing_config_text(config.capture_config, ConfigKind::kCapture));
  }
  return read_capture_config(config.capture_config);
}

// The room is built around the capture grid.
VirtualRoomSettings room_settings(const RigConfig& config, const CaptureConfig& capture,
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

json parsed_request(const std::string& body) {
  json request = json::parse(body, nullptr, false);
  if (!request.is_object()) throw Error("the request is not a JSON object: " + excerpt(body));
  return request;
}

double number_in(const json& request, const char* key, double otherwise) {
  const auto found = request.find(key);
  if (found == request.end()) return otherwise;
  if (!found->is_number()) throw Error(fmt::format("'{}' must be a number", key));
  return found->get<double>();
}

std::string word_in(const json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || !found->is_string()) {
    throw Error(fmt::format("'{}' is missing or not a string", key));
  }
  return found->get<std::string>();
}

FaultRequest fault_in(const json& request) {
  for (const auto& [key, value] : request.items()) {
    if (key != "kind" && key != "for_ms" && key != "after_ms" && key != "amount" &&
        key != "requests") {
      throw Error("unknown key " + excerpt(key));
    }
  }
  FaultRequest fault;
  fault.kind = word_in(request, "kind");
  fault.for_ms = number_in(request, "for_ms", 0.0);
  fault.after_ms = number_in(request, "after_ms", 0.0);
  fault.amount = number_in(request, "amount", 0.0);
  fault.requests = static_cast<int>(number_in(request, "requests", 1.0));
  return fault;
}

}  // namespace

Rig::Rig(const RigConfig& config, const fs::path& directory, Clock* clock)
    : Rig(config, capture_of(config), made(directory), clock) {}

Rig::Rig(const RigConfig& config, const CaptureConfig& capture, const fs::path& directory,
         Clock* clock)
    : config_(config),
      directory_(directory),
      plan_(plan_capture(capture)),
      frame_{config.camera.width_px, config.camera.width_px / 2},
      room_(room_settings(config, capture, plan_)),
      rail_(config.rail, plan_, {config.slider.low_switch_mm, config.slider.high_switch_mm}),
      optics_(config.camera, frame_, config.dolly, -room_.extent().min_m.y(), config.scene.seed),
      ahead_([this](const CameraPose& pose) { return optics_.scene(room_, pose); },
             config.camera.render_ahead_within_mm),
      truth_(&room_, truth_size(config), directory / "truth"),
      line_(plan_.lines.front().id),
      drive_(config.slider, clock),
      link_(config.link),
      camera_(camera_settings(config.camera, frame_, directory / "card"), *clock,
              [this](const ExposureNow& exposure) { return take_picture(exposure); }),
      faults_(&drive_, &link_, &camera_),
      registers_(read_register_map(capture.slider.register_map), &drive_),
      osc_(camera_, config.camera.port) {
  if (config.truth.views > 0) truth_.write_views(config.truth.views);
  drive_.on_move([this](double target_mm) {
    const std::string placed_at = line();
    ahead_.expect(rail_.carriage_pose(placed_at, target_mm, Duration::max()));
    faults_.move_commanded(placed_at, target_mm);
  });
  for (const ScheduledFault& fault : config.faults) faults_.schedule(fault, plan_);
  answer_http();
  osc_.start();
  modbus_.emplace(ModbusServerSettings{capture.slider.unit, slider_device(), config.tcp_port},
                  &registers_, &link_);
}

// Stops the servers before the devices that they use are destroyed.
Rig::~Rig() {
  modbus_.reset();
  osc_.stop();
}

void Rig::answer_http() {
  osc_.on_get("/rig/state", [this](const std::string&) { return state().dump(); });
  osc_.on_post("/rig/place", [this](const std::string& body) {
    const json request = parsed_request(body);
    const double number = std::clamp(number_in(request, "placement", 1.0), 1.0, kMaxPlacements);
    place(placement_id(
        {.id = word_in(request, "line"), .stations = {}, .placement = static_cast<int>(number)}));
    return state().dump();
  });
  osc_.on_post("/rig/fault", [this](const std::string& body) {
    faults_.inject(fault_in(parsed_request(body)));
    return state().dump();
  });
  osc_.on_post("/rig/mend", [this](const std::string&) {
    faults_.clear();
    return state().dump();
  });
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

std::string Rig::take_picture(const ExposureNow& exposure) {
  const std::string placed_at = line();
  const DriveTruth slider = drive_.truth();
  const auto [pose, scene] =
      ahead_.view(rail_.carriage_pose(placed_at, slider.carriage_mm, slider.still_for));
  const auto jpeg = encode_jpeg(optics_.picture(scene, exposure), config_.camera.jpeg_quality);
  truth_.record(exposure.camera_name, placed_at, pose);
  const auto every = static_cast<std::uint64_t>(config_.truth.distance_every);
  if (every > 0 && (exposure.number - 1) % every == 0) {
    truth_.write_distances(exposure.camera_name, pose);
  }
  return {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()};
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
          {"requests", link_.requests()},
          {"link_faults", link_.faults()},
          {"pictures", camera_.pictures_taken()},
          {"camera_faults", camera_.faults().occurred()}};
}

}  // namespace raywalk::capture
