#include "core/evaluate/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/evaluate/kept_results.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/truth_views.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;
using nlohmann::json;

class ValidateTest : public ::testing::Test {
 protected:
  void make_room(const SyntheticRoomSpec& spec) {
    spec_ = spec;
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
    options_.truth = directory_ / "gt.csv";
    options_.report = directory_ / "report";
    options_.connect = {.viewpoints = 2, .k_list_deg = {45.0, 76.0, 90.0}};
    options_.modes = {mode(Generation::kInitial)};
    if (!spec.distances) return;
    options_.modes.push_back(mode(Generation::kHlfVd));
    options_.modes.push_back(mode(Generation::kTwoSided));
  }
  static ViewMode mode(Generation generation) {
    return {.options = {.generation = generation, .k_deg = 80.0}, .k_source = "given"};
  }
  void make_truth(const std::string& name, PlanPoint at, int width) const {
    write_image(directory_ / (name + ".png"), render_truth(spec_, at, width));
  }
  void list(const std::string& rows) const {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z\n" << rows;
  }
  void make_two_truths() const {
    make_truth("near", {0.4, 0.0}, 64);
    make_truth("middle", {0.0, 0.0}, 64);
    list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  }
  std::string run_error() const {
    try {
      validate(room_, options_);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  nlohmann::json metrics() const {
    return nlohmann::json::parse(read_file(options_.report / "metrics.json"));
  }
  std::string page() const { return read_file(options_.report / "index.html"); }

  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
  ValidateOptions options_;
};

std::set<std::string> keys_of(const json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

TEST_F(ValidateTest, WritesTheDocumentedMetrics) {
  make_room({.overhang_m = 0.25, .width = 128});
  make_two_truths();
  validate(room_, options_);
  const json all = metrics();
  EXPECT_EQ(keys_of(all), (std::set<std::string>{"volume", "distances", "captured_width_px",
                                                 "truths", "widest_truth_px", "modes", "views",
                                                 "quarters", "connection", "connection_error"}));
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["volume"], room_.directory().string());
  ASSERT_EQ(all["views"].size(), 6U);
  EXPECT_EQ(keys_of(all["views"][0]),
            (std::set<std::string>{"name", "x_m", "z_m", "line_distance_m", "generation",
                                   "connection", "k_deg", "enlargement", "psnr_db", "ws_psnr_db",
                                   "ssim", "fsim", "limited_corners", "filled_share",
                                   "unseen_share", "empty_share", "render_ms"}));
  EXPECT_EQ(all["views"][0]["name"], "near");
  EXPECT_EQ(all["views"][0]["x_m"], 0.4);
  EXPECT_EQ(all["views"][5]["generation"], "two-sided");
  EXPECT_EQ(all["views"][5]["connection"], "hybrid");
  ASSERT_EQ(all["modes"].size(), 3U);
  const double sum =
      all["views"][0]["psnr_db"].get<double>() + all["views"][3]["psnr_db"].get<double>();
  EXPECT_NEAR(all["modes"][0]["psnr_db"].get<double>(), sum / 2.0, 1e-9);
  EXPECT_GT(all["modes"][1]["psnr_db"], all["modes"][0]["psnr_db"]);
  ASSERT_EQ(all["connection_error"].size(), 9U);
  EXPECT_EQ(all["connection_error"][0]["connection"], "lfu");
  EXPECT_EQ(all["connection_error"][1]["connection"], "hybrid");
  EXPECT_EQ(all["connection_error"][2]["connection"], "rayspace360");
  EXPECT_EQ(all["connection_error"][3]["generation"], "hlf-vd");
  EXPECT_GE(all["connection_error"][0]["e_connect"], 0.0);
  // Each view has four quarters, the same of each generation.
  ASSERT_EQ(all["quarters"].size(), 24U);
  EXPECT_EQ(all["quarters"][4]["generation"], "hlf-vd");
  EXPECT_EQ(all["quarters"][4]["line_distance_m"], all["quarters"][0]["line_distance_m"]);
}

TEST_F(ValidateTest, CorrectedViewsAreAtTheHeightOfTheirTruth) {
  make_room({.overhang_m = 0.25, .width = 128});
  write_image(directory_ / "above.png",
              render_scene(spec_.scene, Eigen::Vector3d(0.1, 0.2, 0.05), 128));
  list("above.png,0.1,0.2,0.05\n");
  validate(room_, options_);
  const json views = metrics()["views"];
  ASSERT_EQ(views.size(), 3U);
  EXPECT_FALSE(views[0].contains("y_m")) << "an initial view is at the height of the lines";
  for (const int corrected : {1, 2}) {
    EXPECT_EQ(views[corrected]["y_m"], 0.2);
    EXPECT_GT(views[corrected]["psnr_db"].get<double>(), 38.0);
  }
}

TEST_F(ValidateTest, TheReportShowsViewsBesideTheirTruth) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_two_truths();
  const std::string said = validate(room_, options_);
  EXPECT_THAT(said, AllOf(HasSubstr("two-sided"), HasSubstr("index.html")));
  EXPECT_THAT(page(), AllOf(HasSubstr("\"kind\":\"validation\""),
                            HasSubstr("near at (0.4, 0) m, 10 cm from the nearest line, hlf-vd"),
                            HasSubstr("true view"), HasSubstr("error, times 4"),
                            HasSubstr("data:image/jpeg")));
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(options_.report)) files += entry.exists();
  EXPECT_EQ(files, 2U);
}

TEST_F(ValidateTest, IdenticalPicturesGiveFiniteJson) {
  make_room({.scene = {.contrast = 0.0}, .width = 64});
  make_two_truths();
  validate(room_, options_);
  EXPECT_EQ(metrics()["modes"][1]["psnr_db"], kMaxPsnrDb);
  EXPECT_EQ(metrics()["modes"][1]["ws_psnr_db"], kMaxPsnrDb);
}

TEST_F(ValidateTest, AnErrorThatCannotBeMeasuredIsNull) {
  // 45 degrees lie between two columns of 5.6 degrees each, so that no column's centre is within a
  // quarter of a degree of them.
  make_room({.overhang_m = 0.25, .width = 64});
  options_.connect = {.viewpoints = 2, .overlap_deg = 0.5, .k_list_deg = {45.0}};
  make_two_truths();
  validate(room_, options_);
  const json row = metrics()["connection_error"][0];
  EXPECT_EQ(row["coverage"], 0.0);
  EXPECT_TRUE(row["e_connect"].is_null());
  EXPECT_TRUE(row["e_connect_common"].is_null());
  EXPECT_EQ(metrics()["connection"]["comparable"], false);
}

// A dolly that is in the true views only: masked pixels affect no score.
TEST_F(ValidateTest, MaskedPixelsOfATruthAreNotCompared) {
  make_room({.width = 64});
  make_two_truths();
  validate(room_, options_);
  const json clean = metrics();
  cv::Mat mask(32, 64, CV_8UC1, cv::Scalar(255));
  mask.rowRange(24, 32).setTo(0);
  write_image(directory_ / "mask.png", mask);
  for (const char* name : {"near.png", "middle.png"}) {
    cv::Mat picture = read_panorama(directory_ / name);
    picture.setTo(cv::Scalar(0, 0, 255), mask == 0);
    write_image(directory_ / name, picture);
  }
  validate(room_, options_);
  const json unmasked = metrics();
  std::ofstream(directory_ / "gt.csv")
      << "file,x,y,z,mask\nnear.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,mask.png\n";
  validate(room_, options_);
  const json masked = metrics();
  for (int mode = 0; mode < 3; ++mode) {
    const auto mean = [mode](const json& all, const char* metric) {
      return all["modes"][mode][metric].get<double>();
    };
    EXPECT_LT(mean(unmasked, "psnr_db"), mean(clean, "psnr_db") - 3.0) << mode;
    EXPECT_GT(mean(masked, "psnr_db"), mean(unmasked, "psnr_db") + 3.0) << mode;
    EXPECT_GT(mean(masked, "ssim"), mean(unmasked, "ssim")) << mode;
    EXPECT_GT(mean(masked, "fsim"), mean(unmasked, "fsim")) << mode;
  }
}

// A silhouette straight ahead and one at the seam, as documented for gt.csv, of one of two truths.
TEST_F(ValidateTest, SilhouettesAreScoredWhereATruthHasDistances) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_two_truths();
  EXPECT_THAT(validate(room_, options_), Not(HasSubstr("silhouettes")));
  EXPECT_FALSE(metrics()["modes"][0].contains("specks_per_megapixel"));
  cv::Mat distances(32, 64, CV_16UC1, cv::Scalar(1000));
  distances.colRange(0, 32).setTo(0);
  fs::create_directories(directory_ / "dist");
  write_image(directory_ / "dist/near.png", distances);
  std::ofstream(directory_ / "gt.csv")
      << "file,x,y,z,distance\nnear.png,0.4,0,0,dist/near.png\nmiddle.png,0,0,0,\n";
  const std::string said = validate(room_, options_);
  const json all = metrics();
  for (int mode = 0; mode < 3; ++mode) {
    const json& view = all["views"][mode];
    EXPECT_EQ(view["near_silhouettes_share"], 12.0 / 64.0);
    const auto error = [&](const char* key) {
      return std::pow(10.0, -0.1 * view[key].get<double>());
    };
    EXPECT_NEAR(
        12.0 / 64.0 * error("psnr_near_silhouettes_db") + 52.0 / 64.0 * error("psnr_elsewhere_db"),
        error("psnr_db"), 1e-12);
    for (const char* key : {"psnr_near_silhouettes_db", "psnr_elsewhere_db",
                            "near_silhouettes_share", "specks_per_megapixel"}) {
      EXPECT_TRUE(view[key].is_number()) << key;
      EXPECT_TRUE(all["views"][3 + mode][key].is_null()) << key;
      EXPECT_EQ(all["modes"][mode][key], view[key]) << key;
    }
  }
  EXPECT_THAT(said, HasSubstr("PSNR near silhouettes (18.8 % of the view)"));
}

TEST_F(ValidateTest, ASingleLineIsValidatedWithItsEmptyShare) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  make_truth("before", {0.0, -0.25}, 64);
  list("before.png,0,0,-0.25\n");
  validate(room_, options_);
  EXPECT_TRUE(metrics()["connection_error"].empty());
  EXPECT_TRUE(metrics()["connection"].is_null());
  EXPECT_TRUE(metrics()["views"][0]["empty_share"].is_number());
}

TEST_F(ValidateTest, AnEnlargedViewSaysByHowMuch) {
  make_room({.overhang_m = 0.25, .width = 64});
  make_truth("near", {0.4, 0.0}, 128);
  make_truth("middle", {0.0, 0.0}, 64);
  list("near.png,0.4,0,0\nmiddle.png,0,0,0\n");
  const std::string said = validate(room_, options_);
  EXPECT_THAT(said, HasSubstr("views up to 128 pixels wide are enlarged 2.0 times from panoramas "
                              "of 64"));
  EXPECT_EQ(metrics()["views"][0]["enlargement"], 2.0);
  EXPECT_EQ(metrics()["views"][3]["enlargement"], 1.0);
  list("middle.png,0,0,0\n");
  EXPECT_THAT(validate(room_, options_), Not(HasSubstr("enlarged")));
}

TEST_F(ValidateTest, RefusesATruthBeforeAnyWork) {
  make_room({.width = 64});
  make_two_truths();
  fs::create_directories(directory_ / "other");
  fs::copy(directory_ / "near.png", directory_ / "other" / "near.png");
  write_image(directory_ / "square.png", cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(0)));
  write_image(directory_ / "odd.png", cv::Mat(33, 66, CV_8UC3, cv::Scalar::all(0)));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"near.png,0.4,0,0\nmiddle.png,7,0,0\n", "gt.csv:3"},
      {"near.png,0.4,0,0\nother/near.png,0,0,0\n", "appears twice"},
      {"gone.png,0,0,0\n", "gone.png"},
      {"square.png,0,0,0\n", "square.png"},
      {"odd.png,0,0,0\n", "multiple of 4"},
      {"near.png,nan,0,0\n", "gt.csv:2"},
      {"", "no views"}};
  for (const auto& [rows, message] : cases) {
    list(rows);
    const std::string error = run_error();
    EXPECT_THAT(error, AllOf(HasSubstr("gt.csv"), HasSubstr(message))) << rows;
    EXPECT_EQ(error.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(options_.report)) << rows;
  }
}

TEST_F(ValidateTest, RefusesAMaskThatDoesNotFitOrLeavesNothing) {
  make_room({.width = 64});
  make_two_truths();
  write_image(directory_ / "small.png", cv::Mat(16, 32, CV_8UC1, cv::Scalar(255)));
  write_image(directory_ / "all.png", cv::Mat::zeros(32, 64, CV_8UC1));
  for (const char* mask : {"small.png", "all.png", "gone.png"}) {
    std::ofstream(directory_ / "gt.csv") << "file,x,y,z,mask\nnear.png,0.4,0,0," << mask << '\n';
    EXPECT_THAT(run_error(), AllOf(HasSubstr("gt.csv:2"), HasSubstr(mask)));
    EXPECT_FALSE(fs::exists(options_.report)) << mask;
  }
}

TEST_F(ValidateTest, RefusesTrueDistancesThatAreMissingOrDoNotFit) {
  make_room({.width = 64});
  make_two_truths();
  write_image(directory_ / "small.png", cv::Mat(16, 32, CV_16UC1, cv::Scalar(1000)));
  for (const auto& [file, message] :
       {std::pair{"small.png", "is 32x16, but 64x32 is needed"}, std::pair{"gone.png", "gone.png"},
        std::pair{"near.png", "16-bit grey"}}) {
    std::ofstream(directory_ / "gt.csv")
        << "file,x,y,z,distance\nnear.png,0.4,0,0," << file << '\n';
    const std::string error = run_error();
    EXPECT_THAT(error, AllOf(HasSubstr("gt.csv:2"), HasSubstr(file), HasSubstr(message)));
    EXPECT_EQ(error.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(options_.report)) << file;
  }
}

TEST_F(ValidateTest, RefusesCorrectedViewsOfARoomWithoutDistances) {
  make_room({.width = 64, .distances = false});
  make_two_truths();
  options_.modes = {mode(Generation::kHlfVd)};
  EXPECT_THAT(run_error(), HasSubstr("raywalk-build-lf depth"));
  EXPECT_FALSE(fs::exists(options_.report));
}

TEST_F(ValidateTest, RefusesAnOverlapThatCannotBeMeasuredBeforeAnyWork) {
  make_room({.width = 64});
  make_two_truths();
  options_.connect.overlap_deg = 0.0;
  EXPECT_THAT(run_error(), HasSubstr("overlap is 0 degrees"));
  EXPECT_FALSE(fs::exists(options_.report));
}

TEST_F(ValidateTest, RefusesAReportThatCannotBeWritten) {
  make_room({.width = 64});
  make_two_truths();
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(run_error(), HasSubstr("report"));
}

// A run that ended at the second truth, whose picture is damaged behind its header.
class ResumedValidateTest : public ValidateTest {
 protected:
  ResumedValidateTest() {
    make_room({.overhang_m = 0.25, .width = 64});
    make_two_truths();
    list_with_distances(500);
  }
  // A silhouette of the first truth lies between half of its columns at 1 m and the others.
  void list_with_distances(int others_mm) const {
    cv::Mat distances(32, 64, CV_16UC1, cv::Scalar(1000));
    distances.colRange(0, 32).setTo(others_mm);
    write_image(directory_ / "distance.png", distances);
    std::ofstream(directory_ / "gt.csv")
        << "file,x,y,z,distance\nnear.png,0.4,0,0,distance.png\nmiddle.png,0,0,0,\n";
  }
  fs::path partial() const { return options_.report / "validation.partial"; }
  void begin() const {
    const std::string picture = read_file(directory_ / "middle.png");
    std::string damaged = picture;
    for (std::size_t i = picture.size() / 2; i < picture.size(); ++i) damaged[i] = 'x';
    write_file_atomically(directory_ / "middle.png", damaged);
    EXPECT_THAT(run_error(), HasSubstr("middle.png"));
    write_file_atomically(directory_ / "middle.png", picture);
  }
  // The times of rendering the first truth's views, which no other run repeats.
  std::set<double> times() const {
    std::set<double> times;
    const json views = metrics()["views"];
    for (int i = 0; i < 3; ++i) times.insert(views[i]["render_ms"].get<double>());
    return times;
  }
  std::set<double> kept_times() const {
    std::set<double> times;
    const std::string text = read_file(partial());
    for (const json& view : json::parse(text.substr(text.find('\n')))) {
      times.insert(view["report"]["render_ms"].get<double>());
    }
    return times;
  }
  // What does not depend on the clock.
  json timeless() const {
    json all = metrics();
    for (json& view : all["views"]) view.erase("render_ms");
    for (json& mode : all["modes"]) mode.erase("median_render_ms");
    return all;
  }
};

TEST_F(ResumedValidateTest, GoesOnWithWhatIsThere) {
  validate(room_, options_);
  const json whole = timeless();
  begin();
  const std::set<double> kept = kept_times();
  ASSERT_EQ(kept.size(), 3U);
  validate(room_, options_);
  EXPECT_EQ(times(), kept);
  EXPECT_EQ(timeless(), whole);
  EXPECT_FALSE(fs::exists(partial()));
}

TEST_F(ResumedValidateTest, ChangedInputsAreMeasuredAnew) {
  const auto anew = [&](const auto& change) {
    begin();
    const std::set<double> kept = kept_times();
    change();
    validate(room_, options_);
    const bool new_times = times() != kept;
    const json resumed = timeless();
    validate(room_, options_);
    EXPECT_EQ(resumed, timeless());
    return new_times;
  };
  EXPECT_FALSE(anew([] {}));
  EXPECT_TRUE(anew([&] { list_with_distances(1000); })) << "other distances";
  EXPECT_TRUE(anew([&] { make_truth("near", {0.41, 0.0}, 64); })) << "another picture";
  EXPECT_TRUE(anew([&] { list("near.png,0.39,0,0\nmiddle.png,0,0,0\n"); })) << "another place";
  EXPECT_TRUE(anew([&] {
    write_image(directory_ / "mask.png", cv::Mat(32, 64, CV_8UC1, cv::Scalar(255)));
    std::ofstream(directory_ / "gt.csv")
        << "file,x,y,z,mask\nnear.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,\n";
  })) << "a mask";
  EXPECT_TRUE(anew([&] {
    for (ViewMode& each : options_.modes) each.options.k_deg = 70.0;
  })) << "another k";
  EXPECT_TRUE(anew([&] {
    spec_.scene.walls.max_m.x() += 0.5;
    write_synthetic_room(spec_, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  })) << "another room";
}

TEST_F(ResumedValidateTest, ConnectionErrorsAreKept) {
  fs::create_directories(options_.report);
  const std::vector<Generation> generations{Generation::kInitial};
  {
    KeptResults kept(partial());
    nlohmann::ordered_json measured;
    add_connect_errors(room_, generations, options_.connect, &kept, &measured);
  }
  std::string text = read_file(partial());
  text = text.substr(text.find('\n') + 1);
  const std::size_t at = text.find("\"e_connect\": ") + 13;
  text.replace(at, text.find(',', at) - at, "1234.5");
  write_file_atomically(partial(), sha256_hex(text) + "\n" + text);
  validate(room_, options_);
  EXPECT_EQ(metrics()["connection_error"][0]["e_connect"], 1234.5);
}

TEST(TrueViews, FewAreSpreadOverTheDistanceFromTheLine) {
  std::vector<ListedTruth> truths(9);
  for (int i = 0; i < 9; ++i) truths[static_cast<std::size_t>(8 - i)].line_distance_m = 0.1 * i;
  EXPECT_THAT(spread_over_distance(truths, 3), ::testing::ElementsAre(8, 4, 0));
  EXPECT_EQ(spread_over_distance(truths, 20).size(), 9U);
}

}  // namespace
}  // namespace raywalk
