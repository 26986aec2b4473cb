#include "simulator/rig/rig.h"

#include <gmock/gmock.h>
#include <httplib.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>
#include <string>

#include "capture/base/manual_clock.h"
#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "core/files/lens_file.h"
#include "core/files/test_support.h"
#include "core/files/test_yaml_keys.h"
#include "simulator/rig/rail.h"
#include "simulator/rig/rig_config.h"
#include "simulator/rig/rig_optics.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;
using namespace capture;
using nlohmann::json;
using testing::AllOf;
using testing::Gt;
using testing::HasSubstr;
using testing::Lt;

constexpr MotionBounds kRigBounds{100.0, 200.0, 200.0};

RailSettings perfect() {
  RailSettings settings;
  settings.placing_spread_mm = settings.direction_spread_deg = settings.tilt_spread_deg = 0.0;
  settings.sag_mm = settings.bow_mm = settings.attitude_spread_deg = settings.vibration_mm = 0.0;
  return settings;
}

// Writes a capture's configuration of one cell of 1 m with five stations to a line, at 100, 350,
// ... 1100 mm on the rail, without overhang; returns a rig for it.
RigConfig small_rig(const fs::path& directory) {
  write_file_atomically(directory / "capture.yaml",
                        "grid:\n  spacing_mm: 250\n  overhang_mm: 0\n"
                        "slider:\n  device: unused\n"
                        "  register_map: " RAYWALK_CONFIGS
                        "/sliders/generic.yaml\n"
                        "  low_limit_mm: 0\n  high_limit_mm: 1200\n  first_station_mm: 100\n"
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

class RigTest : public ::testing::Test {
 protected:
  RigTest() : config_(small_rig(directory_.path())) {}

  std::unique_ptr<Rig> rig() { return std::make_unique<Rig>(config_, directory_ / "rig", &clock_); }
  void home(Rig* rig) {
    rig->drive().home();
    clock_.sleep(std::chrono::seconds(60));
  }
  void go(Rig* rig, double mm) {
    rig->drive().move_to(mm, kRigBounds);
    clock_.sleep(std::chrono::seconds(60));
  }
  // The picture's name on the card.
  std::string shoot(Rig* rig) {
    httplib::Client camera(rig->camera_url());
    const auto run = [&](const char* path, const json& request) {
      return json::parse(camera.Post(path, request.dump(), "text/json")->body);
    };
    const json id = run("/osc/commands/execute", {{"name", "camera.takePicture"}})["id"];
    clock_.sleep(std::chrono::seconds(1));
    const json url = run("/osc/commands/status", {{"id", id}})["results"]["fileUrl"];
    return fs::path(url.get<std::string>()).filename().string();
  }
  CsvTable true_poses() const {
    return CsvTable::read(directory_ / "rig/truth/true_poses.csv",
                          {"file", "line", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  }
  cv::Mat picture(const std::string& name) const {
    return read_panorama(directory_ / "rig/card" / name);
  }
  // From a new rig, at 600 mm.
  cv::Mat picture_at_600_mm() {
    const auto rig = this->rig();
    home(rig.get());
    go(rig.get(), 600.0);
    return picture(shoot(rig.get()));
  }
  static json get(const Rig& rig, const std::string& path) {
    const auto reply = httplib::Client(rig.camera_url()).Get(path);
    return reply && reply->status == 200 ? json::parse(reply->body) : json(nullptr);
  }
  static int post(const Rig& rig, const std::string& path, const std::string& body) {
    const auto reply = httplib::Client(rig.camera_url()).Post(path, body, "application/json");
    return reply ? reply->status : -1;
  }

  const TestDirectory directory_;
  ManualClock clock_;
  RigConfig config_;
};

TEST_F(RigTest, CameraSeesTheRoomFromTheTruePoseOfTheCarriage) {
  config_.rail = perfect();
  config_.truth.distance_every = 2;
  const auto rig = this->rig();
  home(rig.get());
  std::vector<std::string> names;
  for (const char* line : {"x0", "z1"}) {
    rig->place(line);
    for (const double mm : {100.0, 600.0}) {
      go(rig.get(), mm);
      names.push_back(shoot(rig.get()));
    }
  }
  const CsvTable poses = true_poses();
  ASSERT_EQ(poses.rows(), 4U);
  // x0 is the back line (z = -0.5), z1 the right one (x = 0.5); 100 mm is their first station.
  const double expected[4][2] = {{-0.5, -0.5}, {0.0, -0.5}, {0.5, -0.5}, {0.5, 0.0}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(poses.text(i, "file"), names[i]);
    EXPECT_EQ(poses.text(i, "line"), i < 2 ? "x0" : "z1");
    EXPECT_NEAR(poses.number(i, "x"), expected[i][0], 1e-6);
    EXPECT_NEAR(poses.number(i, "y"), 0.0, 1e-6);
    EXPECT_NEAR(poses.number(i, "z"), expected[i][1], 1e-6);
    const fs::path distances = fs::path(names[i]).replace_extension(".png");
    EXPECT_EQ(fs::exists(directory_ / "rig/truth/dist" / distances), i % 2 == 0);
    EXPECT_EQ(picture(names[i]).cols, 64);
  }
}

TEST_F(RigTest, DisplacedRailShowsInTruthAndPicture) {
  config_.rail = perfect();
  const cv::Mat straight = picture_at_600_mm();
  config_.rail.placing_spread_mm = 30.0;
  const cv::Mat displaced = picture_at_600_mm();
  EXPECT_GT(cv::norm(straight, displaced, cv::NORM_INF), 5.0);
  // The second rig appended to the first one's card and table.
  const CsvTable poses = true_poses();
  ASSERT_EQ(poses.rows(), 2U);
  EXPECT_NE(poses.text(0, "file"), poses.text(1, "file"));
  EXPECT_GT(std::abs(poses.number(1, "y")), 1e-4);
}

TEST_F(RigTest, PicturesRenderedAheadAreThoseOfTheRecordedPose) {
  config_.slider.backlash_mm = 0.05;
  std::vector<cv::Mat> pictures;
  for (const double within_mm : {0.0, 0.1, 0.04}) {
    config_.camera.render_ahead_within_mm = within_mm;
    pictures.push_back(picture_at_600_mm());
  }
  EXPECT_LT(cv::norm(pictures[0], pictures[1], cv::NORM_L1) / pictures[0].total(), 1.0);
  const CsvTable poses = true_poses();
  // Reached from the home switch, the carriage stops short of its target by the backlash.
  EXPECT_NEAR(poses.number(1, "x") - poses.number(0, "x"), 50e-6, 1e-6);
  EXPECT_NEAR(poses.number(2, "x"), poses.number(0, "x"), 1e-6) << "not near enough";
}

TEST_F(RigTest, DollyIsInThePicturesOfBothLayoutsButNotInTheTruth) {
  config_.truth.views = 1;
  for (const FrameKind layout : kFrameKinds) {
    config_.camera.layout = layout;
    std::vector<cv::Mat> seen, views;
    for (const bool visible : {false, true}) {
      config_.dolly.visible = visible;
      const auto rig = this->rig();
      seen.push_back(cv::imread((directory_ / ("rig/card/" + shoot(rig.get()))).string()));
      views.push_back(read_panorama(directory_ / "rig/truth/gt/centre.png"));
    }
    cv::Mat difference;
    cv::absdiff(seen[0], seen[1], difference);
    EXPECT_GT(cv::mean(difference.rowRange(27, 31))[1], 3.0) << name_of(layout);
    EXPECT_LT(cv::mean(difference.rowRange(0, 16))[1], 1.0) << name_of(layout);
    EXPECT_EQ(cv::norm(views[0], views[1], cv::NORM_INF), 0.0);
    if (layout == FrameKind::kPanorama) continue;
    EXPECT_LT(cv::norm(seen[0].at<cv::Vec3b>(0, 0)), 40.0) << "dark outside the circles";
    EXPECT_GT(cv::norm(seen[0].at<cv::Vec3b>(16, 16)), 60.0);
  }
}

TEST_F(RigTest, TrueViewsAreWrittenAtTheStartAtTheirOwnSize) {
  config_.truth.views = 3;
  config_.truth.width_px = 48;
  const auto rig = this->rig();
  const CsvTable views =
      CsvTable::read(directory_ / "rig/truth/gt.csv", {"file", "x", "y", "z"}, {"distance"});
  ASSERT_EQ(views.rows(), 3U);
  EXPECT_EQ(views.text(0, "file"), "gt/centre.png");
  EXPECT_EQ(read_panorama(directory_ / "rig/truth/gt/centre.png").cols, 48);
  EXPECT_EQ(read_distance_map(directory_ / "rig/truth/dist/gt_centre.png").cols, 48);
}

TEST_F(RigTest, IsControlledOverHttp) {
  const auto rig = this->rig();
  EXPECT_EQ(get(*rig, "/rig/state")["line"], "x0");
  EXPECT_EQ(get(*rig, "/rig/state")["homed"], false);
  EXPECT_TRUE(get(*rig, "/rig/state")["commanded_mm"].is_null());
  EXPECT_EQ(post(*rig, "/rig/place", R"({"line": "z1", "start_m": [0.5, -0.5]})"), 200);
  EXPECT_EQ(rig->line(), "z1");
  EXPECT_EQ(post(*rig, "/rig/fault", R"({"kind": "alarm", "amount": 12})"), 200);
  EXPECT_EQ(get(*rig, "/rig/state")["alarm_code"], 12);
  EXPECT_EQ(post(*rig, "/rig/mend", ""), 200);
  home(rig.get());
  go(rig.get(), 900.0);
  go(rig.get(), 200.0);
  const json state = get(*rig, "/rig/state");
  EXPECT_EQ(state["homed"], true);
  EXPECT_EQ(state["moves"], 2);
  EXPECT_EQ(state["commanded_mm"], (json{200.0, 900.0}));
  EXPECT_NEAR(state["visited_mm"][0].get<double>(), 0.0, 1e-6);
  EXPECT_NEAR(state["visited_mm"][1].get<double>(), 900.0, 1e-6);
  // The camera's own API is still served.
  EXPECT_TRUE(get(*rig, "/osc/info").contains("model"));
}

TEST_F(RigTest, WrongRequestsAreRefused) {
  const auto rig = this->rig();
  EXPECT_EQ(post(*rig, "/rig/place", R"({"line": "x9"})"), 400);
  EXPECT_EQ(post(*rig, "/rig/place", R"({"row": "x0"})"), 400);
  EXPECT_EQ(post(*rig, "/rig/place", "x0"), 400);
  EXPECT_EQ(post(*rig, "/rig/fault", R"({"kind": "nonsense"})"), 400);
  EXPECT_EQ(post(*rig, "/rig/fault", R"({"kind": "stall", "for": 3})"), 400);
  EXPECT_EQ(post(*rig, "/rig/fault", R"({"kind": "stall", "for_ms": "3"})"), 400);
  EXPECT_EQ(post(*rig, "/rig/fault", R"({"kind": "stall", "at_station": "x9_001"})"), 400);
  rig->drive().move_to(100.0, kRigBounds);
  EXPECT_EQ(post(*rig, "/rig/place", R"({"line": "x1"})"), 400);
  EXPECT_EQ(rig->line(), "x0");
}

// Also at a station of a line's second placement, where positions on the rail repeat.
TEST_F(RigTest, ScheduledFaultOccursDuringTheMoveToItsStation) {
  write_file_atomically(
      config_.capture_config,
      std::regex_replace(read_file(config_.capture_config), std::regex("limit_mm: 1200"),
                         "limit_mm: 700\n  placements_per_line: 2"));
  struct Case {
    std::string line, other_line, station;
    double before_mm;
  };
  for (const auto& [line, other_line, station, before_mm] :
       {Case{"x0", "x0-2", "x0_002", 350.0}, {"x0-2", "x0", "x0_004", 100.0}}) {
    config_.faults = {{.kind = RigFault::kStall, .after_ms = 1000.0, .at_station = station}};
    const auto rig = this->rig();
    home(rig.get());
    rig->place(other_line);
    go(rig.get(), 100.0);
    rig->place(line);
    go(rig.get(), before_mm);
    EXPECT_NEAR(rig->drive().state().feedback_mm, before_mm, 1e-6);
    go(rig.get(), before_mm + 250.0);
    EXPECT_NEAR(rig->drive().state().feedback_mm, before_mm + 75.0, 1e-6) << line;
  }
}

TEST_F(RigTest, InvalidConfigurationsAreRefused) {
  config_.faults = {{.kind = RigFault::kStall, .at_station = "x0_099"}};
  EXPECT_THROW(rig(), UsageError);
  config_.faults.clear();
  config_.capture_config = directory_ / "missing.yaml";
  EXPECT_THROW(rig(), UsageError);
}

// --- The rail ------------------------------------------------------------------------------------

constexpr Duration kLong = std::chrono::hours(1);

// Two lines of 1 m through the origin, stations at 100 to 1100 mm on the rail.
CapturePlan cross_plan() {
  CapturePlan plan{
      .lines = {{"x0", LineAxis::kX, 0.0, false, {}}, {"z0", LineAxis::kZ, 0.0, false, {}}}};
  for (CaptureLine& line : plan.lines) {
    for (int i = 0; i <= 10; ++i) {
      const double along_m = -0.5 + 0.1 * i;
      const bool along_x = line.axis == LineAxis::kX;
      line.stations.push_back(
          {"", along_x ? PlanPoint{along_m, 0.0} : PlanPoint{0.0, along_m}, 100.0 + 100.0 * i});
    }
  }
  return plan;
}

class RailTest : public ::testing::Test {
 protected:
  Rail rail() const { return {settings_, plan_, {0.0, 1200.0}}; }
  // Long after the carriage came to rest.
  CameraPose pose(const std::string& line, double mm) const {
    return rail().carriage_pose(line, mm, kLong);
  }

  const CapturePlan plan_ = cross_plan();
  RailSettings settings_ = perfect();
};

TEST_F(RailTest, SagsBetweenItsSupportsAndBowsToTheLeft) {
  settings_.sag_mm = 2.0;
  settings_.bow_mm = 1.0;
  const auto at = [&](const char* line, double mm) { return pose(line, mm).position_m; };
  EXPECT_NEAR(at("x0", 0.0).y(), 0.0, 1e-12);
  EXPECT_NEAR(at("x0", 600.0).y(), -0.002, 1e-12);
  EXPECT_NEAR(at("x0", 300.0).y(), -0.0015, 1e-12) << "(1 - 0.5^2) of it at a quarter of the span";
  EXPECT_NEAR(at("x0", 600.0).z(), 0.001, 1e-12);
  EXPECT_NEAR(at("z0", 600.0).x(), -0.001, 1e-12);
}

// Along x the camera's right side points along the rail, along z its front does.
TEST_F(RailTest, CameraTurnsWithTheRail) {
  settings_.direction_spread_deg = settings_.tilt_spread_deg = 1.0;
  settings_.sag_mm = 4.0;
  settings_.bow_mm = 3.0;
  for (const double mm : {50.0, 300.0, 600.0, 1100.0}) {
    for (const std::string line : {"x0", "z0"}) {
      const Eigen::Vector3d tangent =
          (pose(line, mm + 0.01).position_m - pose(line, mm - 0.01).position_m).normalized();
      const Eigen::Vector3d own =
          line == "x0" ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d turned = world_from_camera(pose(line, mm).attitude) * own;
      EXPECT_LT((turned - tangent).norm(), 2e-5) << line << mm;
    }
  }
}

TEST_F(RailTest, PlacingsHaveTheGivenSpreadAndAreRepeatable) {
  settings_.placing_spread_mm = 3.0;
  settings_.attitude_spread_deg = 0.5;
  double position = 0.0, yaw = 0.0;
  constexpr int kSeeds = 1000;
  for (settings_.seed = 1; settings_.seed <= kSeeds; ++settings_.seed) {
    const CameraPose placed = pose("z0", 600.0);
    position += placed.position_m.squaredNorm() / 3.0 / kSeeds;
    yaw += placed.attitude.yaw_rad * placed.attitude.yaw_rad / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(position), 0.003, 0.0002);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(yaw)), 0.5, 0.05);
  EXPECT_EQ(pose("x0", 600.0).position_m, pose("x0", 600.0).position_m);
  EXPECT_NE(pose("x0", 600.0).position_m, pose("z0", 600.0).position_m);
}

// The ends are turned by half the twist, in opposite directions.
TEST_F(RailTest, TwistTurnsTheCameraAroundTheRail) {
  settings_.twist_deg = 2.0;
  for (const double share : {-1.0, -0.5, 0.0, 1.0}) {
    for (const std::string line : {"x0", "z0"}) {
      // Clockwise along x takes the top to the back, along z to the right.
      const Eigen::Vector3d up =
          world_from_camera(pose(line, 600.0 + 600.0 * share).attitude) * Eigen::Vector3d::UnitY();
      const double turned_rad = radians_from_degrees(share);
      const Eigen::Vector3d expected =
          line == "x0" ? Eigen::Vector3d(0, std::cos(turned_rad), -std::sin(turned_rad))
                       : Eigen::Vector3d(std::sin(turned_rad), std::cos(turned_rad), 0);
      EXPECT_LT((up - expected).norm(), 1e-12) << line << share;
    }
  }
}

TEST_F(RailTest, JitterHasTheGivenSpreadAndIsFixedPerStation) {
  settings_.jitter_mm = 0.7;
  settings_.jitter_deg = 0.1;
  double squared_m2 = 0.0, squared_rad2 = 0.0;
  int stations = 0;
  for (settings_.seed = 1; settings_.seed <= 100; ++settings_.seed) {
    for (const CaptureLine& line : plan_.lines) {
      for (const CaptureStation& station : line.stations) {
        const auto& [position_m, turned] = pose(line.id, station.rail_mm);
        const Eigen::Vector3d planned_m(station.position_m.x_m, 0.0, station.position_m.z_m);
        squared_m2 += (position_m - planned_m).squaredNorm();
        const Eigen::Vector3d angles_rad(turned.yaw_rad, turned.pitch_rad, turned.roll_rad);
        squared_rad2 += angles_rad.squaredNorm();
        ++stations;
        // A second picture, offset by the backlash, has the same jitter.
        const CameraPose again = pose(line.id, station.rail_mm + 0.02);
        EXPECT_NEAR((again.position_m - position_m).norm(), 2e-5, 1e-12);
        EXPECT_EQ(again.attitude.yaw_rad, turned.yaw_rad);
      }
    }
  }
  // 6,600 deviates: their spread is known to 0.9 %.
  EXPECT_NEAR(std::sqrt(squared_m2 / (3 * stations)), 7e-4, 2.5e-5);
  EXPECT_NEAR(degrees_from_radians(std::sqrt(squared_rad2 / (3 * stations))), 0.1, 3.5e-3);
}

TEST_F(RailTest, VibrationDecays) {
  settings_.vibration_mm = 1.0;
  settings_.vibration_decay_ms = 100.0;
  double largest_at_once = 0.0;
  for (double mm = 100.0; mm <= 1100.0; mm += 100.0) {
    const auto off_mm = [&](std::optional<Duration> still_for) {
      const Eigen::Vector3d shaken_m = rail().carriage_pose("x0", mm, still_for).position_m;
      return 1e3 * (shaken_m - pose("x0", mm).position_m).norm();
    };
    largest_at_once = std::max(largest_at_once, off_mm(Duration::zero()));
    EXPECT_LE(off_mm(duration_from_ms(300.0)), std::sqrt(2.0) * std::exp(-3.0));
    EXPECT_LT(off_mm(duration_from_ms(1500.0)), 1e-5);
    EXPECT_EQ(off_mm(std::nullopt), off_mm(Duration::zero()));
  }
  EXPECT_GT(largest_at_once, 0.7);
}

TEST_F(RailTest, UnknownLineAndEmptySpanAreErrors) {
  EXPECT_TRUE(rail().has_line("x0"));
  EXPECT_FALSE(rail().has_line("x1"));
  EXPECT_THROW(pose("x1", 0.0), Error);
  EXPECT_THROW(Rail(settings_, plan_, {5.0, 5.0}), Error);
}

// --- The configuration ---------------------------------------------------------------------------

constexpr const char* kShipped = RAYWALK_CONFIGS "/simulated-rig.yaml";

RigConfig parsed(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "rig.yaml", yaml);
  return read_rig_config(directory / "rig.yaml");
}

void expect_refused(const std::string& yaml, const std::string& message) {
  EXPECT_THAT(error_of([&] { parsed("capture_config: capture.yaml\n" + yaml); }),
              AllOf(HasSubstr("rig.yaml"), HasSubstr(message)));
}

TEST(RigConfigTest, ShippedFileHoldsEveryKeyWithItsDefault) {
  RigConfig defaults;
  const auto values = rig_schema(&defaults).values();
  std::set<std::string> known;
  for (const auto& entry : values) known.insert(entry.first);
  EXPECT_EQ(keys_of_yaml(kShipped), known);
  RigConfig shipped = read_rig_config(kShipped);
  EXPECT_EQ(shipped.capture_config.filename(), "capture-osc.yaml");
  EXPECT_TRUE(fs::exists(shipped.capture_config));
  shipped.capture_config.clear();
  EXPECT_EQ(rig_schema(&shipped).values(), values);
}

TEST(RigConfigTest, FaultsAreReadInTheirOrder) {
  const RigConfig shipped = read_rig_config(kShipped);
  ASSERT_EQ(shipped.faults.size(), 4U);
  EXPECT_EQ(shipped.faults[0].kind, RigFault::kStall);
  EXPECT_EQ(shipped.faults[0].at_station, "x0_002");
  EXPECT_EQ(shipped.faults[0].after_ms, 100.0);
  EXPECT_EQ(shipped.faults[1].at_request, 500);
  EXPECT_EQ(shipped.faults[2].at_picture, 3);
  EXPECT_EQ(shipped.faults[3].at_s, 60.0);
  EXPECT_EQ(shipped.faults[3].amount, 2.5);
}

TEST(RigConfigTest, EveryGroupIsRead) {
  const RigConfig config = parsed(
      "capture_config: sub/capture.yaml\nscene:\n  seed: 7\n  file: hall\n  x_m: 3\n"
      "slider:\n  backlash_mm: 0.5\n  tcp_port: 1502\nrail:\n"
      "  sag_mm: 3\n  jitter_mm: 0.7\nlink:\n  late: 0.02\ncamera:\n  layout: dual-fisheye\n"
      "  lens: lenses/mine.yaml\n  vignetting: 0.3\n  noise_levels: 2\ndolly:\n"
      "  visible: true\ntruth:\n  views: 5\n");
  EXPECT_THAT(config.capture_config.string(), ::testing::EndsWith("/sub/capture.yaml"));
  EXPECT_EQ(config.scene.seed, 7);
  EXPECT_EQ(config.scene.scene.file, "hall");
  EXPECT_EQ(config.scene.scene.middle_m.x(), 3.0);
  EXPECT_EQ(config.slider.backlash_mm, 0.5);
  EXPECT_EQ(config.tcp_port, 1502);
  EXPECT_EQ(config.rail.sag_mm, 3.0);
  EXPECT_EQ(config.rail.jitter_mm, 0.7);
  EXPECT_EQ(config.link.late, 0.02);
  EXPECT_EQ(config.camera.layout, FrameKind::kDualFisheye);
  EXPECT_THAT(config.camera.lens.string(), ::testing::EndsWith("/lenses/mine.yaml"));
  EXPECT_EQ(config.camera.light.vignetting, 0.3);
  EXPECT_EQ(config.camera.sensor.noise_levels, 2.0);
  EXPECT_TRUE(config.dolly.visible);
  EXPECT_EQ(config.truth.views, 5);
}

TEST(RigConfigTest, MistakesAreNamed) {
  EXPECT_THROW(parsed("scene:\n  seed: 1\n"), UsageError);
  expect_refused("slider:\n  backlash: 1\n", ":3: unknown key 'slider.backlash'");
  expect_refused("slider:\n  power_on_mm: -30\n", "between the switches");
  expect_refused("link:\n  late: 0.6\n  lost: 0.6\n", "more than 1");
  expect_refused("camera:\n  width_px: 66\n", "multiple of 4");
  expect_refused("truth:\n  width_px: 66\n", "multiple of 4");
  expect_refused("camera:\n  vignetting: 0.2\n", "'camera.layout: dual-fisheye'");
  expect_refused("camera:\n  lens: lens.yaml\n", "'camera.layout: dual-fisheye'");
  expect_refused("dolly:\n  reach_deg: 80\n", "dolly.reach_deg");
  expect_refused("scene:\n  grid:\n    cells_x: 2\n", "unknown key");
  expect_refused("faults:\n  - kind: stal\n    at_s: 1\n", "did you mean 'stall'");
  expect_refused("faults:\n  - kind: stall\n", "faults[0] needs exactly one of at_request");
  expect_refused("faults:\n  - kind: stall\n    at_s: 1\n    at_station: x0_001\n", "exactly one");
}

// --- The rehearsal and the lenses that are shipped ----------------------------------------------

const fs::path kConfigs = RAYWALK_CONFIGS;

// Largest distance in pixels between the images of the same direction in two lenses, up to 90
// degrees off the axis.
double largest_difference_px(const FisheyeLens& a, const FisheyeLens& b) {
  double largest = 0.0;
  for (double t = 0.0; t <= kHalfPi; t += 0.1) {
    for (double around = 0.0; around < kTwoPi; around += 0.3) {
      const Eigen::Vector3d direction(std::sin(t) * std::cos(around),
                                      std::sin(t) * std::sin(around), std::cos(t));
      const PixelPosition at_a = *project(a, direction), at_b = *project(b, direction);
      largest = std::max(largest, std::hypot(at_a.u - at_b.u, at_a.v - at_b.v));
    }
  }
  return largest;
}

TEST(ShippedLensesTest, AllAreReadAndOverlapAllAround) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kConfigs / "lenses")) {
    SCOPED_TRACE(entry.path());
    const DualFisheyeCamera camera = read_lens_file(entry.path());
    const DualFisheyeLayout& layout = camera.layout;
    for (const FisheyeLens& lens : {layout.front, layout.back}) {
      EXPECT_GT(lens.largest_angle_rad, radians_from_degrees(94.0));
      EXPECT_LE(lens.centre.u, camera.picture.width);
    }
    EXPECT_LT((layout.front_position_m + layout.back_position_m).norm(), 1e-12)
        << "the origin is half way between the lenses";
    ++files;
  }
  EXPECT_EQ(files, 5);
}

// The starting values must be far enough from the truth to test a calibration, and as close as a
// user's would be.
TEST(ShippedLensesTest, RehearsalStartsSomePixelsFromTheTrueLenses) {
  const DualFisheyeCamera truth = read_lens_file(kConfigs / "lenses/simulated.yaml");
  const DualFisheyeCamera start = read_lens_file(kConfigs / "lenses/dual-fisheye.yaml");
  EXPECT_EQ(truth.picture, start.picture);
  for (const auto& [a, b] : {std::pair{truth.layout.front, start.layout.front},
                             std::pair{truth.layout.back, start.layout.back}}) {
    EXPECT_THAT(largest_difference_px(a, b), AllOf(Gt(4.0), Lt(15.0)));
  }
}

TEST(ShippedRehearsalTest, RigAndCaptureConfigurationsMatch) {
  const RigConfig rig = read_rig_config(kConfigs / "rehearsal-rig.yaml");
  const CaptureConfig capture = read_capture_config(kConfigs / "rehearsal-capture.yaml");
  EXPECT_TRUE(fs::equivalent(rig.capture_config, kConfigs / "rehearsal-capture.yaml"));
  EXPECT_EQ(capture.camera.frames, rig.camera.layout);
  EXPECT_EQ(capture.camera.width_px, rig.camera.width_px);
  EXPECT_EQ(capture.camera.height_px, rig.camera.width_px / 2);
  const PanoramaSize frame{capture.camera.width_px, capture.camera.height_px};
  EXPECT_TRUE(RigOptics(rig.camera, frame, rig.dolly, 1.0, 1).lenses());
  EXPECT_EQ(plan_capture(capture).lines.size(), 5U);
}

// Errors typical of rails placed by hand: lines up to 20 mm and 1.5 degrees off, stations by about
// as much. Offsets along the line do not count, as they do not affect the grid.
TEST(ShippedRehearsalTest, LinesHaveErrorsTypicalOfManualPlacement) {
  const RigConfig rig = read_rig_config(kConfigs / "rehearsal-rig.yaml");
  const CapturePlan plan = plan_capture(read_capture_config(kConfigs / "rehearsal-capture.yaml"));
  const Rail rail(rig.rail, plan, {rig.slider.low_switch_mm, rig.slider.high_switch_mm});
  double farthest_m = 0.0, most_turned_rad = 0.0;
  for (const CaptureLine& line : plan.lines) {
    for (const CaptureStation& station : line.stations) {
      const CameraPose pose = rail.carriage_pose(line.id, station.rail_mm, kLong);
      const Eigen::Vector3d off_m =
          pose.position_m - Eigen::Vector3d(station.position_m.x_m, 0.0, station.position_m.z_m);
      const double across_m = line.axis == LineAxis::kX ? off_m.z() : off_m.x();
      farthest_m = std::max(farthest_m, std::hypot(across_m, off_m.y()));
      const auto& [yaw_rad, pitch_rad, roll_rad] = pose.attitude;
      most_turned_rad =
          std::max({most_turned_rad, std::abs(yaw_rad), std::abs(pitch_rad), std::abs(roll_rad)});
    }
  }
  EXPECT_THAT(farthest_m, AllOf(Gt(0.012), Lt(0.022)));
  EXPECT_THAT(degrees_from_radians(most_turned_rad), AllOf(Gt(0.8), Lt(1.6)));
}

// --- Its optics ---------------------------------------------------------------------------------

constexpr PanoramaSize kFrame{160, 80};
constexpr double kFloor_m = 1.2;

const VirtualRoom& empty_room() {
  static const VirtualRoom room({.scene = {.file = "empty"}});
  return room;
}

RigOptics optics_of(const RigCameraSettings& camera, const DollySettings& dolly = {}) {
  return {camera, kFrame, dolly, kFloor_m, 1};
}

cv::Mat picture_of(const RigCameraSettings& camera, const DollySettings& dolly = {},
                   std::uint64_t number = 1) {
  const RigOptics optics = optics_of(camera, dolly);
  return optics.picture(optics.scene(empty_room(), {}), {.camera_name = {}, .number = number});
}

double mean_of(const cv::Mat& picture) { return cv::mean(picture)[1]; }

TEST(RigOpticsTest, SeesThroughTheLensesOfItsFileAtItsOwnSize) {
  const TestDirectory directory;
  DualFisheyeCamera lens{.picture = {1600, 800}, .layout = simple_dual_fisheye({1600, 800})};
  lens.layout.front.centre.u += 40.0;
  lens.layout.back.k[0] = 0.02;
  write_lens_file(directory / "lens.yaml", lens);
  RigCameraSettings camera{.layout = FrameKind::kDualFisheye};
  const cv::Mat simple = picture_of(camera);
  camera.lens = directory / "lens.yaml";
  const RigOptics optics = optics_of(camera);
  EXPECT_NEAR(optics.lenses()->front.centre.u, simple_dual_fisheye(kFrame).front.centre.u + 4.0,
              1e-9);
  EXPECT_EQ(optics.lenses()->back.k[0], 0.02);
  EXPECT_GT(cv::norm(picture_of(camera), simple, cv::NORM_INF), 30.0);
  EXPECT_FALSE(optics_of({}).lenses());
}

TEST(RigOpticsTest, LensFilesOfOtherLayoutsAreRefused) {
  const TestDirectory directory;
  DualFisheyeCamera lens{.picture = {1600, 900}, .layout = simple_dual_fisheye({1600, 800})};
  const RigCameraSettings camera{.layout = FrameKind::kDualFisheye,
                                 .lens = directory / "lens.yaml"};
  const auto expect_refused = [&](const std::string& message) {
    EXPECT_THAT(error_of([&] { optics_of(camera); }),
                AllOf(HasSubstr("lens.yaml"), HasSubstr(message)));
  };
  expect_refused("not a file");
  write_lens_file(camera.lens, lens);
  expect_refused("1600 x 900");
  lens.picture = {1600, 800};
  lens.two_files = true;
  write_lens_file(camera.lens, lens);
  expect_refused("two files");
}

TEST(RigOpticsTest, LensesHaveVignettingAndDifferentGain) {
  RigCameraSettings camera{.layout = FrameKind::kDualFisheye};
  const cv::Mat even = picture_of(camera);
  camera.light.lens_gain_ev = -1.0;
  const cv::Mat darker_back = picture_of(camera);
  EXPECT_EQ(cv::norm(even.colRange(0, 80), darker_back.colRange(0, 80), cv::NORM_INF), 0.0);
  EXPECT_LT(mean_of(darker_back.colRange(80, 160)), 0.85 * mean_of(even.colRange(80, 160)));
  camera.light = {0.5, 0.0};
  const cv::Mat vignetted = picture_of(camera);
  const cv::Rect middle(36, 36, 8, 8), rim(36, 2, 8, 4);
  EXPECT_NEAR(mean_of(vignetted(middle)), mean_of(even(middle)), 2.0);
  EXPECT_LT(mean_of(vignetted(rim)), 0.85 * mean_of(even(rim)));
}

TEST(RigOpticsTest, LightDriftsSlowlyAndWithinItsBounds) {
  double largest = 0.0, largest_step = 0.0;
  for (int seed = 1; seed <= 5; ++seed) {
    for (std::uint64_t picture = 1; picture <= 400; ++picture) {
      const double here = exposure_drift(picture, seed);
      largest = std::max(largest, std::abs(here));
      largest_step = std::max(largest_step, std::abs(exposure_drift(picture + 1, seed) - here));
    }
  }
  EXPECT_GT(largest, 0.8);
  EXPECT_LE(largest, 1.0);
  EXPECT_LT(largest_step, 0.12);
  RigCameraSettings camera;
  EXPECT_EQ(mean_of(picture_of(camera, {}, 1)), mean_of(picture_of(camera, {}, 30)));
  camera.exposure_drift_ev = 0.5;
  EXPECT_GT(std::abs(mean_of(picture_of(camera, {}, 1)) - mean_of(picture_of(camera, {}, 30))),
            2.0);
}

}  // namespace
}  // namespace raywalk::simulator
