#include "core/evaluate/truth_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <utility>
#include <vector>

#include "core/base/test_error.h"
#include "core/evaluate/held_out.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/test_truths.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::SizeIs;

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

}  // namespace
}  // namespace raywalk
