#include "simulator/rig/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "capture/base/manual_clock.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::simulator {
namespace {

using namespace capture;

using nlohmann::json;
using ::testing::HasSubstr;

constexpr const char* kMap = RAYWALK_CONFIGS "/sliders/generic.yaml";
constexpr MotionBounds kRigBounds{100.0, 200.0, 200.0};

// Writes a capture's configuration of one cell of 1 m with five stations to a line, at 100, 350,
// ... 1100 mm on the rail, without overhang; returns a rig for it.
RigConfig small_rig(const std::filesystem::path& directory,
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

class RigTest : public ::testing::Test {
 protected:
  RigTest() : config_(small_rig(directory_.path(), kMap)) {}

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
    const auto run = [rig](const char* path, const json& request) {
      return json::parse(
          httplib::Client(rig->camera_url()).Post(path, request.dump(), "text/json")->body);
    };
    const json id = run("/osc/commands/execute", {{"name", "camera.takePicture"}})["id"];
    clock_.sleep(std::chrono::seconds(1));
    const json url = run("/osc/commands/status", {{"id", id}})["results"]["fileUrl"];
    return std::filesystem::path(url.get<std::string>()).filename().string();
  }
  CsvTable true_poses() const {
    return CsvTable::read(directory_ / "rig/truth/true_poses.csv",
                          {"file", "line", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  }
  static json get(const Rig& rig, const std::string& path) {
    const auto reply = httplib::Client(rig.camera_url()).Get(path);
    return reply && reply->status == 200 ? json::parse(reply->body) : json(nullptr);
  }
  static int post(const Rig& rig, const std::string& path, const std::string& body) {
    const auto reply = httplib::Client(rig.camera_url()).Post(path, body, "application/json");
    return reply ? reply->status : -1;
  }
  void without_rail_errors() {
    RailSettings& rail = config_.rail;
    rail.placing_spread_mm = rail.direction_spread_deg = rail.tilt_spread_deg = 0.0;
    rail.sag_mm = rail.bow_mm = rail.attitude_spread_deg = rail.vibration_mm = 0.0;
  }

  const TestDirectory directory_;
  ManualClock clock_;
  RigConfig config_;
};

TEST_F(RigTest, CameraSeesTheRoomFromTheTruePoseOfTheCarriage) {
  without_rail_errors();
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
    const auto stem = std::filesystem::path(names[i]).stem().string();
    EXPECT_EQ(std::filesystem::exists(directory_ / ("rig/truth/dist/" + stem + ".png")),
              i % 2 == 0);
    EXPECT_EQ(read_panorama(directory_ / ("rig/card/" + names[i])).cols, 64);
  }
}

TEST_F(RigTest, DisplacedRailShowsInTruthAndPicture) {
  without_rail_errors();
  cv::Mat straight, displaced;
  for (const double spread_mm : {0.0, 30.0}) {
    config_.rail.placing_spread_mm = spread_mm;
    const auto rig = this->rig();
    home(rig.get());
    go(rig.get(), 600.0);
    (spread_mm == 0.0 ? straight : displaced) =
        read_panorama(directory_ / ("rig/card/" + shoot(rig.get())));
  }
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
    const auto rig = this->rig();
    home(rig.get());
    go(rig.get(), 600.0);
    pictures.push_back(read_panorama(directory_ / ("rig/card/" + shoot(rig.get()))));
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
  std::string capture = read_file(config_.capture_config);
  const std::string limit = "high_limit_mm: 1200";
  capture.replace(capture.find(limit), limit.size(),
                  "high_limit_mm: 700\n  placements_per_line: 2");
  write_file_atomically(config_.capture_config, capture);
  for (const auto& [line, station] : {std::pair{"x0", "x0_002"}, std::pair{"x0-2", "x0_004"}}) {
    config_.faults = {{.kind = RigFault::kStall, .after_ms = 1000.0, .at_station = station}};
    const auto rig = this->rig();
    home(rig.get());
    rig->place(line == std::string("x0") ? "x0-2" : "x0");
    go(rig.get(), 100.0);
    rig->place(line);
    const double before_mm = line == std::string("x0") ? 350.0 : 100.0;
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

}  // namespace
}  // namespace raywalk::simulator
