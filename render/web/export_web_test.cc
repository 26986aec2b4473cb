#include "render/web/export_web.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/base/interrupt.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json.h"
#include "core/files/test_support.h"
#include "core/room/distance_maps.h"
#include "core/room/requirements.h"
#include "core/view/distance_view.h"
#include "core/view/renderer.h"
#include "core/view/test_room.h"
#include "render/web/inverse_file.h"
#include "render/web/station_distances.h"
#include "render/web/station_pictures.h"

namespace raywalk::render {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// As the page reads it. Throws std::runtime_error unless the stream holds exactly a map of that
// width.
InverseMap decoded_inverse(std::span<const std::byte> stream, int width, double step_per_m) {
  InverseMap map({width, width / 2});
  const std::size_t pixels = map.values().size();
  std::vector<std::uint8_t> bytes(2 * pixels + 1);
  uLongf size = bytes.size();
  const int result =
      uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(stream.data()), stream.size());
  if (result != Z_OK || size != 2 * pixels) throw std::runtime_error("not a map of this width");
  for (int theta = 0; theta < width; ++theta) {
    std::uint16_t value = 0;
    for (int row = 0; row < width / 2; ++row) {
      const auto i = static_cast<std::size_t>(row * width + theta);
      value = static_cast<std::uint16_t>(value + bytes[i] + (bytes[pixels + i] << 8));
      map.at(theta, row) = static_cast<float>(value * step_per_m);
    }
  }
  return map;
}

TEST(InverseFile, HoldsFallsAndRisesOverTheWholeRange) {
  InverseMap map({16, 8});
  for (int theta = 0; theta < 16; ++theta) {
    for (int row = 0; row < 8; ++row) map.at(theta, row) = (theta + row) % 2 == 0 ? 0.0F : 2.0F;
  }
  map.at(3, 4) = 5.0F;  // too near, which becomes the nearest
  const double step_per_m = 2.0 / kLargestInverseValue;
  const InverseMap read = decoded_inverse(encode_inverse(map, step_per_m), 16, step_per_m);
  map.at(3, 4) = 2.0F;
  EXPECT_TRUE(std::ranges::equal(read.values(), map.values()));
}

TEST(InverseFile, SmoothDistancesAreFewBytes) {
  InverseMap map({512, 256});
  for (int theta = 0; theta < 512; ++theta) {
    for (int row = 0; row < 256; ++row) {
      map.at(theta, row) = static_cast<float>(std::sin(0.01 * row) * std::cos(0.01 * theta) + 1.0);
    }
  }
  EXPECT_LT(encode_inverse(map, 2.0 / kLargestInverseValue).size(), map.values().size_bytes() / 6);
}

class ExportWebTest : public ::testing::Test {
 protected:
  ExportWebTest() {
    make_directories(directory_ / "page");
    for (const char* name : {"index.html", "viewer.js", "viewer.css"}) {
      write_file_atomically(directory_ / "page" / name, name);
    }
    options_.page = directory_ / "page";
  }

  // Written once.
  static const TestRoom& captured() {
    static const TestRoom room(box_room(192));
    return room;
  }
  fs::path out() const { return directory_ / "web"; }
  std::string run(bool replace = false) const {
    return export_web(captured().room(), options_, out(), replace);
  }
  std::string error() const {
    return error_of([&] { run(); });
  }
  json manifest() const { return json::parse(read_file(out() / "manifest.json")); }
  InverseMap inverse(const std::string& name) const {
    const json distances = manifest()["distances"];
    const std::string bytes = read_file(out() / "stations" / (name + ".inverse"));
    return decoded_inverse(std::as_bytes(std::span(bytes)), distances["width_px"],
                           distances["inverse_step_per_m"]);
  }
  cv::Mat picture(const std::string& name) const {
    return read_panorama(out() / "stations" / name);
  }
  // As `raywalk-build-lf require` leaves it.
  static void require_spacing(double spacing_m) {
    const json required = {
        {"format", kRequirementsFormat},
        {"format_version", kRequirementsVersion},
        {"distances_sha256", distances_sha256(captured().room())},
        {"layers", {{"inverse_max_per_m", 1.0}}},
        {"spacing", {{"needed_with_distances_m", spacing_m}}},
        {"storage", {{"worth_width_px", 1e3}, {"needed_distance_width_px", 64}}}};
    write_file_atomically(requirements_path(captured().room().directory()), required.dump());
  }

  TestDirectory directory_;
  WebExportOptions options_;
};

TEST_F(ExportWebTest, TheManifestDescribesTheRoom) {
  options_.title = "Hall \"A\"";
  options_.start = PlanPoint{0.125, -0.25};
  options_.k_deg = 80.0;
  const std::string summary = run();
  const json m = manifest();
  EXPECT_EQ(m["format"], "raywalk-web");
  EXPECT_EQ(m["version"], 1);
  EXPECT_EQ(m["title"], "Hall \"A\"");
  EXPECT_EQ(m["budget_mb"], 256.0);
  EXPECT_EQ(m["panorama"], json({{"width_px", 192}, {"coarse_width_px", 96}}));
  EXPECT_EQ(m["distances"]["width_px"], 192);
  EXPECT_FLOAT_EQ(m["distances"]["surface_tolerance"], surface_tolerance_of(192));
  EXPECT_EQ(
      m["view"],
      json({{"method", "two-sided"}, {"k_deg", 80.0}, {"overlap_deg", 5.0}, {"distance_maps", 8}}));
  EXPECT_EQ(m["start"], json({{"x_m", 0.125}, {"z_m", -0.25}, {"yaw_deg", 0.0}}));
  EXPECT_EQ(m["vertical_range_m"], 0.5) << "nothing is hidden in an empty room";
  EXPECT_TRUE(m["quality"].is_null());
  for (const char* key : {"truth", "hotspots", "path"}) EXPECT_EQ(m[key], json::array()) << key;

  const Grid& grid = captured().room().grid();
  ASSERT_EQ(m["lines"].size(), grid.lines.size());
  int index = 0;
  for (std::size_t i = 0; i < grid.lines.size(); ++i) {
    const json& line = m["lines"][i];
    EXPECT_EQ(line["id"], grid.lines[i].id);
    EXPECT_EQ(line["origin_m"], json({grid.lines[i].origin.x_m, grid.lines[i].origin.z_m}));
    EXPECT_EQ(line["direction"], json({grid.lines[i].direction.x_m, grid.lines[i].direction.z_m}));
    EXPECT_NEAR(line["spacing_m"], 0.125, 1e-9);
    ASSERT_EQ(line["stations"].size(), grid.lines[i].stations.size());
    for (std::size_t j = 0; j < grid.lines[i].stations.size(); ++j, ++index) {
      const Station& station = grid.lines[i].stations[j];
      EXPECT_EQ(line["stations"][j]["along_m"], station.along_m);
      EXPECT_EQ(line["stations"][j]["position_m"],
                json({station.position_m.x(), station.position_m.y(), station.position_m.z()}));
      const std::string name = line["stations"][j]["name"];
      EXPECT_EQ(std::stoi(name), index);
      for (const char* end : {".jpg", "-coarse.jpg", ".inverse"}) {
        EXPECT_TRUE(fs::exists(out() / "stations" / (name + end))) << name << end;
      }
    }
  }
  ASSERT_EQ(m["cells"].size(), 1U);
  EXPECT_EQ(m["cells"][0]["lines"], json(grid.cells[0].line));
  EXPECT_EQ(m["cells"][0]["x_max_m"], grid.cells[0].x_max_m);
  EXPECT_EQ(read_file(out() / "viewer.js"), "viewer.js");
  EXPECT_THAT(summary, AllOf(HasSubstr("all 52; raywalk-build-lf require"),
                             HasSubstr("192 pixels wide"), HasSubstr("all stations are exported")));
  EXPECT_EQ(directory_.entries(), 2U) << "page and web";
}

TEST_F(ExportWebTest, PicturesAndDistancesAreTheStations) {
  run();
  EXPECT_EQ(picture("0000-coarse.jpg").size(), cv::Size(96, 48));
  StationDistances distances(captured().room(), 192);
  const double step_per_m = manifest()["distances"]["inverse_step_per_m"];
  float largest = 0.0F;
  int index = 0;
  for (int line = 0; line < 4; ++line) {
    for (int station = 0; station < 13; ++station, ++index) {
      const std::string name = fmt::format("{:04}", index);
      const cv::Mat expected = captured_picture_at(captured().room(), line, station, 192);
      EXPECT_GT(psnr_db(picture(name + ".jpg"), expected), 38.0) << name;
      const InverseMap seen = distances.seen_from(line, station);
      const InverseMap read = inverse(name);
      double off = 0.0;
      for (std::size_t i = 0; i < seen.values().size(); ++i) {
        off = std::max<double>(off, std::abs(seen.values()[i] - read.values()[i]));
        largest = std::max(largest, seen.values()[i]);
      }
      EXPECT_LE(off, 0.51 * step_per_m) << name;
    }
  }
  EXPECT_NEAR(step_per_m * 65535.0, largest, 1e-6);
}

TEST_F(ExportWebTest, HoldsTheStationsThatTheSceneRequires) {
  require_spacing(0.25);
  options_.measure_quality = [](const Room& room, const KeptStations& kept,
                                const ViewOptions& options) {
    EXPECT_EQ(room.grid().lines[0].stations.size(), 13U);
    EXPECT_EQ(kept[0].size(), 7U);
    EXPECT_EQ(options.width, 192);
    return WebQuality{.psnr_db = 34.5, .worst_psnr_db = 30.0, .views = 12, .text = "measured so"};
  };
  EXPECT_THAT(run(), AllOf(HasSubstr("28 of 52"), HasSubstr("measured so")));
  fs::remove(requirements_path(captured().room().directory()));
  const json m = manifest();
  ASSERT_EQ(m["lines"][3]["stations"].size(), 7U);
  EXPECT_EQ(m["lines"][3]["stations"][6]["name"], "0027");
  EXPECT_NEAR(m["lines"][3]["spacing_m"], 0.25, 1e-9);
  EXPECT_EQ(m["distances"]["width_px"], 64);
  EXPECT_EQ(m["quality"]["psnr_db"], 34.5);
  EXPECT_EQ(m["quality"]["text"], "measured so");
  EXPECT_GT(psnr_db(picture("0001.jpg"), captured_picture_at(captured().room(), 0, 2, 192)), 38.0);
}

TEST_F(ExportWebTest, TakesAlongPathHotspotsAndTruth) {
  std::ofstream(directory_ / "walk.csv") << "name,x,y,z,yaw\na,0,0,0,90\nb,0.25,0.1,-0.25,0\n";
  std::ofstream(directory_ / "spots.json")
      << R"([{"x_m": 1, "y_m": 0.5, "z_m": -1, "text": "Window", "link": "window.html"}])";
  write_image(directory_ / "truth.png", captured().truth({0.1, 0.2}, 256));
  std::ofstream(directory_ / "gt.csv") << "file,x,y,z\ntruth.png,0.1,0,0.2\n./truth.png,3,0,0\n"
                                          "././truth.png,0.1,0.25,0.2\n";
  options_.path = directory_ / "walk.csv";
  options_.hotspots = directory_ / "spots.json";
  options_.truth = directory_ / "gt.csv";
  run();
  const json m = manifest();
  // A quarter turn at 40 degrees per second, which takes longer than the way.
  ASSERT_EQ(m["path_frames_per_s"], 10.0);
  ASSERT_EQ(m["path"].size(), 23U);
  EXPECT_EQ(m["path"][0], json::parse(R"({"x_m": 0.0, "z_m": 0.0, "y_m": 0.0, "yaw_deg": 90.0,
                                          "pitch_deg": 0.0, "roll_deg": 0.0})"));
  EXPECT_NEAR(m["path"][11]["y_m"], 0.05, 1e-9);
  EXPECT_NEAR(m["path"][22]["y_m"], 0.1, 1e-9);
  EXPECT_EQ(m["hotspots"], json::parse(read_file(directory_ / "spots.json")));
  ASSERT_EQ(m["truth"].size(), 2U) << "the other lies in no cell";
  EXPECT_EQ(m["truth"][0]["x_m"], 0.1);
  const cv::Mat truth = read_panorama(out() / m["truth"][0]["picture"].get<std::string>());
  const cv::Mat engine = read_panorama(out() / m["truth"][0]["engine"].get<std::string>());
  EXPECT_GT(psnr_db(truth, captured().truth({0.1, 0.2})), 36.0);
  const ViewOptions view{.method = ViewMethod::kTwoSided};
  EXPECT_GT(psnr_db(engine, captured().image(view, {0.1, 0.2})), 38.0);
  const cv::Mat raised = read_panorama(out() / m["truth"][1]["engine"].get<std::string>());
  Renderer renderer(captured().room(), view);
  EXPECT_GT(psnr_db(raised, renderer.render({PlanPoint{0.1, 0.2}, 0.25}).image), 38.0);
}

TEST_F(ExportWebTest, RefusesWhatLiesOutsideTheRoom) {
  options_.start = PlanPoint{5.0, 0.0};
  EXPECT_THAT(error(), HasSubstr("--start 5,0"));
  options_.start.reset();
  std::ofstream(directory_ / "walk.csv") << "name,x,z\na,0,0\naway,9,9\n";
  options_.path = directory_ / "walk.csv";
  EXPECT_THAT(error(), AllOf(HasSubstr("walk.csv"), HasSubstr("away")));
  options_.path.clear();
  write_image(directory_ / "truth.png", captured().truth({0.1, 0.2}));
  std::ofstream(directory_ / "gt.csv") << "file,x,y,z\ntruth.png,3,0,0\n";
  options_.truth = directory_ / "gt.csv";
  EXPECT_THAT(error(), AllOf(HasSubstr("gt.csv"), HasSubstr("cell")));
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_FALSE(fs::exists(out().string() + ".partial"));
}

TEST_F(ExportWebTest, RefusesOptionsOutOfRange) {
  options_.budget_mb = 0.0;
  EXPECT_THROW(run(), UsageError);
  options_ = {.width_px = 3, .page = options_.page};
  EXPECT_THROW(run(), UsageError);
  options_ = {.k_deg = 44.0, .page = options_.page};
  EXPECT_THROW(run(), UsageError);
}

TEST_F(ExportWebTest, TellsThatThePageIsNotInstalled) {
  options_.page = directory_ / "nowhere";
  EXPECT_THAT(error(), AllOf(HasSubstr("page is not installed"), HasSubstr("Node.js")));
  EXPECT_THAT(viewer_page().string(), ::testing::EndsWith("/share/raywalk/viewer"));
}

TEST_F(ExportWebTest, ReplacesAnEarlierExport) {
  const TestRoom small(box_room(64));
  export_web(small.room(), options_, out(), false);
  EXPECT_THAT(error(), HasSubstr("--out"));
  options_.title = "again";
  export_web(small.room(), options_, out(), true);
  EXPECT_EQ(manifest()["title"], "again");
}

TEST_F(ExportWebTest, ARoomWithoutDistancesIsExportedForInitialViews) {
  const TestRoom bare({.width = 64, .distances = false});
  export_web(bare.room(), options_, out(), false);
  const json m = manifest();
  EXPECT_EQ(m["view"]["method"], "initial");
  EXPECT_EQ(m["vertical_range_m"], 0.0);
  EXPECT_GT(m["distances"]["inverse_step_per_m"], 0.0);
  EXPECT_THAT(inverse("0000").values(), ::testing::Each(0.0F));
}

TEST_F(ExportWebTest, ALineWithoutCellsStartsInItsMiddle) {
  const TestRoom line({.cells_z = 0, .width = 64});
  export_web(line.room(), options_, out(), false);
  const json m = manifest();
  EXPECT_EQ(m["cells"], json::array());
  EXPECT_NEAR(m["start"]["x_m"], 0.0, 1e-9);
}

TEST_F(ExportWebTest, WhatIsHiddenLimitsTheEyesHeight) {
  // The floor behind a low block shows only from above.
  const TestRoom blocked({.scene = {.obstacle = SceneBox{{-0.3, -1.2, -0.3}, {0.3, -0.05, 0.3}}},
                          .overhang_m = 0.25,
                          .width = 192});
  export_web(blocked.room(), options_, out(), false);
  EXPECT_LT(manifest()["vertical_range_m"], 0.5);
}

using ExportWebDeathTest = ExportWebTest;

TEST_F(ExportWebDeathTest, AnInterruptedExportLeavesNothing) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  captured();  // is written before the interrupt
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        std::raise(SIGINT);
        try {
          run();
        } catch (const Interrupted& e) {
          const bool clean = directory_.entries() == 1;  // the page
          std::exit(clean && std::string(e.what()).find("0 of 52") != std::string::npos ? 42 : 1);
        }
        std::exit(2);
      },
      testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace raywalk::render
