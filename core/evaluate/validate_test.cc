// True views, stations held out as such, and the validation against them.
#include "core/evaluate/validate.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/evaluate/held_out.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/test_truths.h"
#include "core/evaluate/truth_views.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
namespace fs = std::filesystem;

// Every pixel holds its column.
cv::Mat numbered_columns(int width) {
  cv::Mat image(width / 2, width, CV_8UC3);
  for (int u = 0; u < width; ++u) image.col(u).setTo(cv::Scalar::all(u));
  return image;
}

// A camera that looks to +90 degrees sees the world's column u + width / 4 in its column u.
TEST(ReadView, PicturesWithAnAttitudeAreTurnedToTheWorld) {
  const TestDirectory directory;
  write_synthetic_room({}, directory / "room.lf");
  const Room room = Room::open(directory / "room.lf");
  const cv::Mat world = numbered_columns(64);
  const auto seen = [](const cv::Mat& image) {
    cv::Mat turned;
    cv::hconcat(image.colRange(16, 64), image.colRange(0, 16), turned);
    return turned;
  };
  cv::Mat mask(32, 64, CV_8UC1, cv::Scalar(255)), map(32, 64, CV_16UC1);
  mask.colRange(40, 50).setTo(0);
  for (int u = 0; u < 64; ++u) map.col(u).setTo(cv::Scalar(1000 + u));
  write_image(directory / "a.png", seen(world));
  write_image(directory / "mask.png", seen(mask));
  write_image(directory / "map.png", seen(map));
  const std::filesystem::path list = directory / "gt.csv";
  write_file_atomically(list, std::string("file,x,y,z,yaw,mask,distance\n"
                                          "a.png,0.1,0,0.1,90,mask.png,map.png\n"));
  const TrueView view = read_view(read_truth(list, room).at(0));
  EXPECT_LE(cv::norm(view.image, world, cv::NORM_INF), 1.0);
  EXPECT_EQ(cv::norm(view.distances, map, cv::NORM_INF), 0.0);
  EXPECT_EQ(view.mask.at<uchar>(16, 45), 0);
  EXPECT_EQ(view.mask.at<uchar>(16, 30), 255);
}

TEST(ExposedAs, IsTheTruthsExposureWhateverIsDisplaced) {
  cv::Mat view(64, 128, CV_8UC3);
  cv::randu(view, 40, 180);
  TrueView truth;
  cv::multiply(view, cv::Scalar(1.1, 0.95, 1.05), truth.image);
  truth.image.colRange(0, 30).setTo(cv::Scalar::all(100));  // something else is there
  EXPECT_EQ(exposed_as(truth, view).data, view.data);
  truth.own_exposure = true;
  const cv::Mat exposed = exposed_as(truth, view);
  EXPECT_LE(cv::norm(exposed.colRange(30, 128), truth.image.colRange(30, 128), cv::NORM_INF), 1.0);
  EXPECT_GT(cv::norm(exposed.colRange(0, 30), truth.image.colRange(0, 30), cv::NORM_INF), 20.0);
}

TEST(QuarterScores, AQuarterIsCentredOnItsDirection) {
  const cv::Mat image = numbered_columns(64);
  // theta = 0 is the edge between columns 31 and 32; 8 columns lie on either side of it.
  for (const auto& [theta_rad, first] : {std::pair{0.0, 24}, {kHalfPi, 40}, {kPi, 56}}) {
    const cv::Mat quarter = quarter_of(image, theta_rad);
    ASSERT_EQ(quarter.cols, 16);
    for (int u = 0; u < 16; ++u) EXPECT_EQ(quarter.at<cv::Vec3b>(0, u)[0], (first + u) % 64);
  }
}

TEST(QuarterScores, EverySideHasItsDistanceAndItsError) {
  const Grid grid = synthetic_grid({});
  TrueView truth;
  truth.viewpoint = {0.3, 0.1};
  truth.image = numbered_columns(64);
  cv::Mat view = truth.image.clone();
  cv::Mat to_the_right = view.colRange(44, 50);
  cv::add(to_the_right, cv::Scalar::all(9), to_the_right);
  const ordered_json scores = quarter_scores_of(grid, view, truth, features_of(view, truth));
  ASSERT_EQ(scores.size(), 4U);
  for (const auto& [side, distance_m] : {std::pair{0, 0.4}, {1, 0.2}, {2, 0.6}, {3, 0.8}}) {
    EXPECT_NEAR(scores[side]["line_distance_m"].get<double>(), distance_m, 1e-9);
    EXPECT_EQ(scores[side]["psnr_db"] == kMaxPsnrDb, side != 1);
  }
  EXPECT_LT(scores[1]["psnr_db"], 50.0);
  // A single line serves the side it is seen on.
  truth.viewpoint = {0.0, -0.25};
  const ordered_json of_line =
      quarter_scores_of(synthetic_grid({.cells_z = 0}), view, truth, features_of(view, truth));
  ASSERT_EQ(of_line.size(), 1U);
  EXPECT_NEAR(of_line[0]["line_distance_m"].get<double>(), 0.25, 1e-9);
}

TEST(Scores, MeansAreOverTheRowsThatHaveThem) {
  const std::vector<ordered_json> rows{
      {{"a", 1.0}, {"b", nullptr}}, {{"b", nullptr}}, {{"a", 4.0}}};
  EXPECT_EQ(mean_of(rows, "a"), 2.5);
  EXPECT_TRUE(mean_of(rows, "b").is_null());
}

TEST(TrueViews, FewAreSpreadOverTheDistanceFromTheLine) {
  std::vector<ListedTruth> truths(9);
  for (int i = 0; i < 9; ++i) truths[static_cast<std::size_t>(8 - i)].line_distance_m = 0.1 * i;
  EXPECT_THAT(spread_over_distance(truths, 3), ::testing::ElementsAre(8, 4, 0));
  EXPECT_EQ(spread_over_distance(truths, 20).size(), 9U);
}

class HeldOutTest : public TruthTest {
 protected:
  // A cell of 1 m, stations every 1/16 m from 1/4 m before it to 1/4 m behind it.
  HeldOutTest() { make_room({.spacing_m = 0.0625, .overhang_m = 0.25, .width = 64}); }
};

TEST_F(HeldOutTest, TheRoomLacksTheStations) {
  const HeldOutViews held_out = held_out_views(room_, 4, 100);
  ASSERT_FALSE(held_out.views.empty());
  std::set<std::string> names;
  for (const TrueView& view : held_out.views) {
    names.insert(view.name);
    ASSERT_TRUE(find_cell(room_.grid(), view.viewpoint).has_value());
    for (int line = 0; line < 4; ++line) {
      const auto& all = room_.grid().lines[static_cast<size_t>(line)];
      const auto& left = held_out.room.grid().lines[static_cast<size_t>(line)];
      EXPECT_LT(left.stations.size(), all.stations.size());
      EXPECT_EQ(left.first_m(), all.first_m());
      EXPECT_EQ(left.last_m(), all.last_m());
      for (const Station& station : left.stations) EXPECT_NE(station.file, view.name + ".png");
      EXPECT_EQ(held_out.room.distances(line).maps(), static_cast<int>(left.stations.size()));
    }
  }
  EXPECT_EQ(names.size(), held_out.views.size());
}

TEST_F(HeldOutTest, TruthsAreTheCapturedFramesOfAllLines) {
  const HeldOutViews held_out = held_out_views(room_, 4, 4);
  ASSERT_THAT(held_out.views, SizeIs(4));
  std::set<std::string> lines;
  for (const TrueView& view : held_out.views) {
    lines.insert(view.name.substr(0, 2));
    EXPECT_EQ(view.width, 64);
    EXPECT_EQ(cv::norm(view.image, render_truth(spec_, view.viewpoint, 64), cv::NORM_INF), 0.0);
    EXPECT_TRUE(view.mask.empty());
  }
  EXPECT_THAT(lines, SizeIs(4));
}

TEST_F(HeldOutTest, MaskedPixelsAreNotCompared) {
  spec_.companion = CameraCompanion{
      .hides = [](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < -0.8; }};
  make_room(spec_);
  for (const TrueView& view : held_out_views(room_, 4, 2).views) {
    ASSERT_EQ(view.mask.size(), view.image.size());
    EXPECT_EQ(view.mask.at<std::uint8_t>(0, 5), 255);
    EXPECT_EQ(view.mask.at<std::uint8_t>(view.mask.rows - 1, 5), 0);
  }
}

TEST_F(HeldOutTest, ImpossibleHoldOutsAreRejected) {
  EXPECT_THROW(held_out_views(room_, 1, 4), UsageError);
  EXPECT_THROW(held_out_views(room_, 0, 4), UsageError);
  make_room({.spacing_m = 1.0, .width = 64});
  EXPECT_THAT(error_of([&] { held_out_views(room_, 8, 4); }), HasSubstr("true views with --truth"));
}

class ValidateTest : public TruthTest {
 protected:
  ValidateTest() {
    options_.truth = truth_;
    options_.report = report_;
    options_.connect = {.viewpoints = 2, .k_list_deg = {45.0, 76.0, 90.0}};
    options_.modes = {mode(ViewMethod::kInitial), mode(ViewMethod::kHlfVd),
                      mode(ViewMethod::kTwoSided)};
  }
  static ViewMode mode(ViewMethod method) {
    return {.options = {.method = method, .k_deg = 80.0}, .k_source = "given"};
  }
  // The metrics that a run writes, and what it says.
  json validated() {
    said_ = validate(room_, options_);
    return json_in(report_ / "metrics.json");
  }
  // Of a run that is refused before any work.
  std::string refusal() const {
    const std::string error = error_of([&] { validate(room_, options_); });
    EXPECT_EQ(error.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(report_)) << error;
    return error;
  }

  ValidateOptions options_;
  std::string said_;
};

TEST_F(ValidateTest, WritesTheDocumentedMetrics) {
  make_room({.overhang_m = 0.25, .width = 128});
  const json all = validated();
  EXPECT_EQ(keys_of(all),
            (std::set<std::string>{"volume", "distances", "captured_width_px", "truths",
                                   "exposure_matched", "widest_truth_px", "modes", "views",
                                   "quarters", "connection", "connection_error"}));
  EXPECT_EQ(all["distances"], "given");
  EXPECT_EQ(all["volume"], room_.directory().string());
  const json &views = all["views"], &modes = all["modes"], &errors = all["connection_error"];
  ASSERT_EQ(views.size(), 6U);
  EXPECT_EQ(keys_of(views[0]),
            (std::set<std::string>{"name", "x_m", "z_m", "line_distance_m", "method", "connection",
                                   "k_deg", "enlargement", "psnr_db", "ws_psnr_db", "ssim", "fsim",
                                   "limited_corners", "filled_share", "unseen_share", "empty_share",
                                   "render_ms"}));
  EXPECT_EQ(views[0]["name"], "near");
  EXPECT_EQ(views[0]["x_m"], 0.4);
  EXPECT_EQ(views[5]["method"], "two-sided");
  EXPECT_EQ(views[5]["connection"], "hybrid");
  ASSERT_EQ(modes.size(), 3U);
  const double sum = views[0]["psnr_db"].get<double>() + views[3]["psnr_db"].get<double>();
  EXPECT_NEAR(modes[0]["psnr_db"].get<double>(), sum / 2.0, 1e-9);
  EXPECT_GT(modes[1]["psnr_db"], modes[0]["psnr_db"]);
  ASSERT_EQ(errors.size(), 9U);
  EXPECT_EQ(errors[0]["connection"], "lfu");
  EXPECT_EQ(errors[1]["connection"], "hybrid");
  EXPECT_EQ(errors[2]["connection"], "rayspace360");
  EXPECT_EQ(errors[3]["method"], "hlf-vd");
  EXPECT_GE(errors[0]["e_connect"], 0.0);
  // Each view has four quarters, the same of each method.
  ASSERT_EQ(all["quarters"].size(), 24U);
  EXPECT_EQ(all["quarters"][4]["method"], "hlf-vd");
  EXPECT_EQ(all["quarters"][4]["line_distance_m"], all["quarters"][0]["line_distance_m"]);
}

TEST_F(ValidateTest, CorrectedViewsAreAtTheHeightOfTheirTruth) {
  make_room({.overhang_m = 0.25, .width = 128});
  write_image(directory_ / "above.png",
              render_scene(spec_.scene, Eigen::Vector3d(0.1, 0.2, 0.05), 128));
  list("above.png,0.1,0.2,0.05\n");
  const json views = validated()["views"];
  ASSERT_EQ(views.size(), 3U);
  EXPECT_FALSE(views[0].contains("y_m")) << "an initial view is at the height of the lines";
  for (const int corrected : {1, 2}) {
    EXPECT_EQ(views[corrected]["y_m"], 0.2);
    EXPECT_GT(views[corrected]["psnr_db"].get<double>(), 38.0);
  }
}

TEST_F(ValidateTest, TheReportShowsViewsBesideTheirTruth) {
  validated();
  EXPECT_THAT(said_, AllOf(HasSubstr("two-sided"), HasSubstr("index.html")));
  EXPECT_THAT(
      read_file(report_ / "index.html"),
      AllOf(HasSubstr("\"kind\":\"validation\""),
            HasSubstr("near at (0.4, 0) m, 10 cm from the nearest line, hlf-vd"),
            HasSubstr("true view"), HasSubstr("error, times 4"), HasSubstr("data:image/jpeg")));
  EXPECT_EQ(files(), (std::set<std::string>{"index.html", "metrics.json"}));
}

// 45 degrees lie between two columns of 5.6 degrees each, so that no column's centre is within a
// quarter of a degree of them.
TEST_F(ValidateTest, IdenticalPicturesAndErrorsThatCannotBeMeasuredGiveValidJson) {
  make_room({.scene = {.contrast = 0.0}, .overhang_m = 0.25, .width = 64});
  make_truth("near", {0.4, 0.0}, 64);
  list("near.png,0.4,0,0\n");
  options_.connect = {.viewpoints = 2, .overlap_deg = 0.5, .k_list_deg = {45.0}};
  const json all = validated(), row = all["connection_error"][0];
  EXPECT_EQ(all["modes"][1]["psnr_db"], kMaxPsnrDb);
  EXPECT_EQ(all["modes"][1]["ws_psnr_db"], kMaxPsnrDb);
  EXPECT_EQ(row["coverage"], 0.0);
  EXPECT_TRUE(row["e_connect"].is_null());
  EXPECT_TRUE(row["e_connect_common"].is_null());
  EXPECT_EQ(all["connection"]["comparable"], false);
}

// A dolly that is in the true views only: masked pixels affect no score.
TEST_F(ValidateTest, MaskedPixelsOfATruthAreNotCompared) {
  const json clean = validated()["modes"];
  cv::Mat mask(32, 64, CV_8UC1, cv::Scalar(255));
  mask.rowRange(24, 32).setTo(0);
  write_image(directory_ / "mask.png", mask);
  for (const char* name : {"near.png", "middle.png"}) {
    cv::Mat picture = read_panorama(directory_ / name);
    picture.setTo(cv::Scalar(0, 0, 255), mask == 0);
    write_image(directory_ / name, picture);
  }
  const json unmasked = validated()["modes"];
  list("near.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,mask.png\n", ",mask");
  const json masked = validated()["modes"];
  for (std::size_t mode = 0; mode < 3; ++mode) {
    const auto mean = [mode](const json& modes, const char* metric) {
      return modes[mode][metric].get<double>();
    };
    EXPECT_LT(mean(unmasked, "psnr_db"), mean(clean, "psnr_db") - 3.0) << mode;
    EXPECT_GT(mean(masked, "psnr_db"), mean(unmasked, "psnr_db") + 3.0) << mode;
    EXPECT_GT(mean(masked, "ssim"), mean(unmasked, "ssim")) << mode;
    EXPECT_GT(mean(masked, "fsim"), mean(unmasked, "fsim")) << mode;
  }
}

// A silhouette straight ahead and one at the seam, as documented for gt.csv, of one of two truths.
TEST_F(ValidateTest, SilhouettesAreScoredWhereATruthHasDistances) {
  EXPECT_FALSE(validated()["modes"][0].contains("specks_per_megapixel"));
  EXPECT_THAT(said_, Not(HasSubstr("silhouettes")));
  cv::Mat distances(32, 64, CV_16UC1, cv::Scalar(1000));
  distances.colRange(0, 32).setTo(0);
  fs::create_directories(directory_ / "dist");
  write_image(directory_ / "dist/near.png", distances);
  list("near.png,0.4,0,0,dist/near.png\nmiddle.png,0,0,0,\n", ",distance");
  const json all = validated();
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
  EXPECT_THAT(said_, HasSubstr("PSNR near silhouettes (18.8 % of the view)"));
}

TEST_F(ValidateTest, ASingleLineIsValidatedWithItsEmptyShare) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  make_truth("before", {0.0, -0.25}, 64);
  list("before.png,0,0,-0.25\n");
  const json all = validated();
  EXPECT_TRUE(all["connection_error"].empty());
  EXPECT_TRUE(all["connection"].is_null());
  EXPECT_TRUE(all["views"][0]["empty_share"].is_number());
}

TEST_F(ValidateTest, AnEnlargedViewSaysByHowMuch) {
  make_truth("near", {0.4, 0.0}, 128);
  const json views = validated()["views"];
  EXPECT_THAT(said_, HasSubstr("views up to 128 pixels wide are enlarged 2.0 times from panoramas "
                               "of 64"));
  EXPECT_EQ(views[0]["enlargement"], 2.0);
  EXPECT_EQ(views[3]["enlargement"], 1.0);
  list("middle.png,0,0,0\n");
  validated();
  EXPECT_THAT(said_, Not(HasSubstr("enlarged")));
}

TEST_F(ValidateTest, RefusesTruthsMasksAndDistancesBeforeAnyWork) {
  fs::create_directories(directory_ / "other");
  fs::copy(directory_ / "near.png", directory_ / "other" / "near.png");
  write_image(directory_ / "square.png", cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(0)));
  write_image(directory_ / "odd.png", cv::Mat(33, 66, CV_8UC3, cv::Scalar::all(0)));
  write_image(directory_ / "small.png", cv::Mat(16, 32, CV_8UC1, cv::Scalar(255)));
  write_image(directory_ / "all.png", cv::Mat::zeros(32, 64, CV_8UC1));
  write_image(directory_ / "small16.png", cv::Mat(16, 32, CV_16UC1, cv::Scalar(1000)));
  const struct {
    std::string rows, more, message;
  } cases[] = {{"near.png,0.4,0,0\nmiddle.png,7,0,0\n", "", "gt.csv:3"},
               {"near.png,0.4,0,0\nother/near.png,0,0,0\n", "", "appears twice"},
               {"gone.png,0,0,0\n", "", "gone.png"},
               {"square.png,0,0,0\n", "", "square.png"},
               {"odd.png,0,0,0\n", "", "multiple of 4"},
               {"near.png,nan,0,0\n", "", "gt.csv:2"},
               {"", "", "no views"},
               {"near.png,0.4,0,0,small.png\n", ",mask", "small.png"},
               {"near.png,0.4,0,0,all.png\n", ",mask", "all.png"},
               {"near.png,0.4,0,0,gone.png\n", ",mask", "gone.png"},
               {"near.png,0.4,0,0,small16.png\n", ",distance", "is 32x16, but 64x32 is needed"},
               {"near.png,0.4,0,0,gone.png\n", ",distance", "gone.png"},
               {"near.png,0.4,0,0,near.png\n", ",distance", "16-bit grey"}};
  for (const auto& [rows, more, message] : cases) {
    list(rows, more);
    const std::string where = more.empty() ? "gt.csv" : "gt.csv:2";
    EXPECT_THAT(refusal(), AllOf(HasSubstr(where), HasSubstr(message))) << rows;
  }
}

TEST_F(ValidateTest, RefusesWhatCannotBeMeasuredOrWritten) {
  options_.connect.overlap_deg = 0.0;
  EXPECT_THAT(refusal(), HasSubstr("overlap is 0 degrees"));
  options_.connect.overlap_deg = 5.0;
  std::ofstream(directory_ / "file") << "x";
  options_.report = directory_ / "file" / "report";
  EXPECT_THAT(refusal(), HasSubstr("report"));
  options_.report = report_;
  make_room({.width = 64, .distances = false});
  EXPECT_THAT(refusal(), HasSubstr("raywalk-build-lf depth"));
}

// A run that ended at the second truth, whose picture is damaged behind its header.
class ResumedValidateTest : public ValidateTest {
 protected:
  ResumedValidateTest() { list_with_distances(500); }
  // A silhouette of the first truth lies between half of its columns at 1 m and the others.
  void list_with_distances(int others_mm) const {
    cv::Mat distances(32, 64, CV_16UC1, cv::Scalar(1000));
    distances.colRange(0, 32).setTo(others_mm);
    write_image(directory_ / "distance.png", distances);
    list("near.png,0.4,0,0,distance.png\nmiddle.png,0,0,0,\n", ",distance");
  }
  // The times of rendering the first truth's views, which no other run repeats.
  std::set<double> begin() const {
    const std::string picture = read_file(directory_ / "middle.png");
    std::string damaged = picture;
    for (std::size_t i = damaged.size() / 2; i < damaged.size(); ++i) damaged[i] = 'x';
    write_file_atomically(directory_ / "middle.png", damaged);
    EXPECT_THAT(error_of([&] { validate(room_, options_); }), HasSubstr("middle.png"));
    write_file_atomically(directory_ / "middle.png", picture);
    std::set<double> times;
    for (const json& kept : kept_in(report_ / "validation.partial")) {
      times.insert(kept["view"]["render_ms"].get<double>());
    }
    return times;
  }
  static std::set<double> times(const json& all) {
    std::set<double> times;
    for (int i = 0; i < 3; ++i) times.insert(all["views"][i]["render_ms"].get<double>());
    return times;
  }
  // What does not depend on the clock.
  static json timeless(json all) {
    for (json& view : all["views"]) view.erase("render_ms");
    for (json& mode : all["modes"]) mode.erase("median_render_ms");
    return all;
  }
};

TEST_F(ResumedValidateTest, GoesOnWithWhatIsThereUnlessInputsHaveChanged) {
  const auto anew = [&](const auto& change) {
    const std::set<double> kept = begin();
    EXPECT_EQ(kept.size(), 3U);
    change();
    const json resumed = validated();
    EXPECT_EQ(files(), (std::set<std::string>{"index.html", "metrics.json"}));
    EXPECT_EQ(timeless(resumed), timeless(validated()));
    return times(resumed) != kept;
  };
  EXPECT_FALSE(anew([] {}));
  EXPECT_TRUE(anew([&] { list_with_distances(1000); })) << "other distances";
  EXPECT_TRUE(anew([&] { make_truth("near", {0.41, 0.0}, 64); })) << "another picture";
  EXPECT_TRUE(anew([&] { list("near.png,0.39,0,0\nmiddle.png,0,0,0\n"); })) << "another place";
  EXPECT_TRUE(anew([&] {
    write_image(directory_ / "mask.png", cv::Mat(32, 64, CV_8UC1, cv::Scalar(255)));
    list("near.png,0.4,0,0,mask.png\nmiddle.png,0,0,0,\n", ",mask");
  })) << "a mask";
  EXPECT_TRUE(anew([&] {
    for (ViewMode& each : options_.modes) each.options.k_deg = 70.0;
  })) << "another k";
  EXPECT_TRUE(anew([&] {
    spec_.scene.walls.max_m.x() += 0.5;
    make_room(spec_);
  })) << "another room";
}

}  // namespace
}  // namespace raywalk
