// Lists of captured panoramas against the ray-traced truth.
#include "calibrate/rectify/rectify_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "core/panorama/panorama_rotation.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr PanoramaSize kSize{256, 128};
constexpr int kStations = 4;

double psnr_db(const cv::Mat& a, const cv::Mat& b) {
  const double squares = cv::norm(a, b, cv::NORM_L2SQR);
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.total()) * 3.0 / squares);
}

// Two crossing lines and a validation line, with another attitude at every station.
class RectifySetTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    capture::VirtualRoomSettings settings;
    room_ = new capture::VirtualRoom(settings);
    set_ = new CaptureSet();
    poses_ = new FramePoses();
    frames_ = new TestDirectory();
    set_->source = frames_->path();
    set_->frame = kSize;
    set_->lines = {{.id = "x0", .axis = LineAxis::kX, .across_m = 0.0},
                   {.id = "z0", .axis = LineAxis::kZ, .across_m = 0.0},
                   {.id = "v0", .axis = LineAxis::kX, .across_m = 0.1, .validation = true}};
    for (int line = 0; line < 3; ++line) {
      for (int i = 0; i < kStations; ++i) add_station(line, i);
    }
  }
  static void TearDownTestSuite() {
    delete room_;
    delete set_;
    delete poses_;
    delete frames_;
  }
  static void add_station(int line, int i) {
    CaptureLine& of = set_->lines[static_cast<std::size_t>(line)];
    const int index = static_cast<int>(set_->frames.size());
    const double along_m = 0.05 * (i - 1.5);
    const Eigen::Vector3d nominal_m = of.axis == LineAxis::kX
                                          ? Eigen::Vector3d(along_m, 0.0, of.across_m)
                                          : Eigen::Vector3d(of.across_m, 0.0, along_m);
    const Attitude attitude{0.02 * (line + 1), -0.01 * i, 0.015 * (i - line)};
    FramePose pose{.position_m = nominal_m + Eigen::Vector3d(0.001, 0.002, -0.0015),
                   .world_from_camera = world_from_camera(attitude),
                   .origin = PoseOrigin::kSolved};
    const cv::Mat seen = room_->render(capture::PanoramaRays(kSize), {pose.position_m, attitude});
    const std::string name = of.id + "_" + std::to_string(i);
    const fs::path file = *frames_ / (name + ".png");
    write_image(file, seen);
    set_->frames.push_back({.name = name, .line = line, .file = file, .nominal_m = nominal_m});
    of.frames.push_back(index);
    poses_->emplace_back(pose);
  }

  RectifyOptions options() const { return {.out = out_.path() / "calibration"}; }
  fs::path in_out(const std::string& file) const { return out_.path() / "calibration" / file; }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(in_out("rectify.json"))); }
  // Mean PSNR over the frames of a list, in world axes, against upright ground truth where they
  // were taken. The list has the order of the set.
  double mean_psnr_db(const std::string& list, std::size_t first) const {
    double sum = 0.0;
    const std::vector<Frame> frames = read_frame_list(in_out(list));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const cv::Mat truth =
          room_->render(capture::PanoramaRays(kSize), {(*poses_)[first + i]->position_m, {}});
      sum += psnr_db(truth,
                     rotate_panorama(read_panorama(frames[i].path),
                                     world_from_camera(frames[i].attitude.value_or(Attitude{}))));
    }
    return sum / static_cast<double>(frames.size());
  }

  static capture::VirtualRoom* room_;
  static CaptureSet* set_;
  static FramePoses* poses_;
  static TestDirectory* frames_;
  TestDirectory out_;
};
capture::VirtualRoom* RectifySetTest::room_ = nullptr;
CaptureSet* RectifySetTest::set_ = nullptr;
FramePoses* RectifySetTest::poses_ = nullptr;
TestDirectory* RectifySetTest::frames_ = nullptr;

TEST_F(RectifySetTest, ListsHoldThePosesAndTheValidationLineApart) {
  const RectifyResult result = rectify_set(*set_, *poses_, options());
  EXPECT_EQ(result.frames, 2 * kStations);
  EXPECT_EQ(result.validation_frames, kStations);
  EXPECT_TRUE(result.left_out.empty());
  const std::vector<Frame> listed = read_frame_list(in_out("poses.csv"));
  ASSERT_EQ(listed.size(), 2U * kStations);
  EXPECT_EQ(listed[0].path, set_->frames[0].file);
  EXPECT_LT((listed[0].position_m - (*poses_)[0]->position_m).norm(), 1e-8);
  EXPECT_FALSE(listed[0].mask);
  EXPECT_EQ(listed[0].line, "x0");
  const std::vector<Frame> truth = read_frame_list(in_out("gt.csv"));
  ASSERT_EQ(truth.size(), static_cast<std::size_t>(kStations));
  EXPECT_EQ(truth[0].path, set_->frames[2 * kStations].file);
  EXPECT_FALSE(fs::exists(in_out("rectified")));
  // Panoramas of 256 pixels resampled once have 31 dB against upright ray-traced ones.
  EXPECT_GT(mean_psnr_db("poses.csv", 0), 29.0);
  EXPECT_GT(mean_psnr_db("gt.csv", 2 * kStations), 29.0);
  EXPECT_LT(mean_psnr_db("before.csv", 0), 24.0);
}

// A capture and its calibration are moved together.
TEST_F(RectifySetTest, PicturesBesideTheCalibrationAreNamedRelativeToIt) {
  RectifyOptions beside = options();
  beside.out = frames_->path() / "calibration";
  rectify_set(*set_, *poses_, beside);
  EXPECT_EQ(read_frame_list(beside.out / "poses.csv")[0].file, "../x0_0.png");
  fs::remove_all(beside.out);
}

TEST_F(RectifySetTest, OverlaysShowTheLinesAgree) {
  const RectifyResult result = rectify_set(*set_, *poses_, options());
  ASSERT_GE(result.crossings.size(), 1U);
  for (const CrossingComparison& crossing : result.crossings) {
    EXPECT_LT(crossing.difference_after, 0.8 * crossing.difference_before);
    EXPECT_TRUE(fs::exists(in_out(crossing.after.string())));
  }
  const auto written = report();
  EXPECT_EQ(written["grid_frames"], result.frames);
  EXPECT_EQ(written["frames"][3]["file"], set_->frames[3].file.string());
  ASSERT_EQ(written["crossings"].size(), result.crossings.size());
  EXPECT_EQ(written["figures"][0]["file"], result.crossings[0].before.generic_string());
  EXPECT_EQ(written["line_tolerance_mm"], result.line_tolerance_mm.value());
  EXPECT_TRUE(written["same_station_mm"].is_null());
}

TEST_F(RectifySetTest, FramesWithoutAPoseAreListed) {
  FramePoses poses = *poses_;
  poses[2].reset();
  const RectifyResult result = rectify_set(*set_, poses, options());
  EXPECT_THAT(result.left_out, ElementsAre("x0_2"));
  EXPECT_EQ(read_frame_list(in_out("poses.csv")).size(), 2U * kStations - 1);
  for (auto& pose : poses) pose.reset();
  EXPECT_THROW(rectify_set(*set_, poses, options()), Error);
}

TEST_F(RectifySetTest, FramesBeforeTheCalibrationAreListedWithTheSameStations) {
  FramePoses poses = *poses_;
  poses[2].reset();
  rectify_set(*set_, poses, options());
  const std::vector<Frame> before = read_frame_list(in_out("before.csv"));
  ASSERT_EQ(before.size(), read_frame_list(in_out("poses.csv")).size());
  EXPECT_EQ(before[0].path, set_->frames[0].file);
  EXPECT_EQ(before[2].path, set_->frames[3].file);
  EXPECT_LT((before[2].position_m - set_->frames[3].nominal_m).norm(), 1e-8);
  EXPECT_FALSE(before[0].mask);
  EXPECT_FALSE(fs::exists(in_out("joined_masks")));

  CaptureSet own = *set_;
  cv::Mat half(kSize.height, kSize.width, CV_8UC1, cv::Scalar(255));
  half.colRange(0, 10).setTo(0);
  make_directories(in_out("panoramas"));
  write_image(in_out("panoramas/own.png"), half);
  own.frames[1].mask = in_out("panoramas/own.png");
  rectify_set(own, poses, options());
  EXPECT_EQ(read_frame_list(in_out("before.csv"))[1].mask, in_out("panoramas/own.png"));
  EXPECT_THAT(read_file(in_out("before.csv")), HasSubstr(",panoramas/own.png,x0\n"));
  RectifyOptions masked = options();
  masked.mask = cv::Mat(kSize.height, kSize.width, CV_8UC1, cv::Scalar(255));
  masked.mask->rowRange(120, 128).setTo(0);
  rectify_set(own, poses, masked);
  const std::vector<Frame> joined = read_frame_list(in_out("before.csv"));
  ASSERT_TRUE(joined[0].mask && joined[1].mask);
  const cv::Mat common = read_mask(*joined[0].mask, kSize),
                both = read_mask(*joined[1].mask, kSize);
  EXPECT_EQ(common.at<uchar>(10, 5), 255);
  EXPECT_EQ(both.at<uchar>(10, 5), 0);
  EXPECT_EQ(common.at<uchar>(125, 50), 0);
  EXPECT_EQ(both.at<uchar>(125, 50), 0);
}

// A frame between the stations that is no station, and one that has no pose.
struct WithHeldOut {
  CaptureSet set{};
  FramePoses poses{};

  WithHeldOut(const CaptureSet& stations, const FramePoses& posed, const fs::path& directory,
              const capture::VirtualRoom& room)
      : set(stations), poses(posed) {
    FramePose pose{.position_m = {0.02, 0.0, 0.03},
                   .world_from_camera = world_from_camera({0.1, 0.0, 0.02})};
    const cv::Mat seen =
        room.render(capture::PanoramaRays(kSize), {pose.position_m, {0.1, 0.0, 0.02}});
    for (const char* name : {"t0", "unposed"}) {
      write_image(directory / (std::string(name) + ".png"), seen);
      set.frames.push_back({.name = name,
                            .line = kHeldOut,
                            .file = directory / (std::string(name) + ".png"),
                            .nominal_m = pose.position_m,
                            .where = "gt.csv:2"});
    }
    poses.emplace_back(pose);
    poses.emplace_back(std::nullopt);
  }
};

TEST_F(RectifySetTest, HeldOutFramesAreListedApartFromTheStations) {
  const RectifyResult alone = rectify_set(*set_, *poses_, options());
  const std::string stations = read_file(in_out("poses.csv"));
  const WithHeldOut more(*set_, *poses_, out_.path(), *room_);
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const RectifyResult result = rectify_set(more.set, more.poses, options());
  const std::string said =
      testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("held-out frame unposed has no pose"));
  EXPECT_THAT(result.left_out, ElementsAre("unposed"));
  EXPECT_EQ(result.frames, alone.frames);
  EXPECT_EQ(result.validation_frames, kStations + 1);
  EXPECT_EQ(read_file(in_out("poses.csv")), stations);
  const std::vector<Frame> truth = read_frame_list(in_out("gt.csv"));
  ASSERT_EQ(truth.size(), static_cast<std::size_t>(kStations + 1));
  EXPECT_TRUE(fs::equivalent(truth.back().path, out_ / "t0.png"));
  ASSERT_TRUE(truth.back().attitude);
  EXPECT_NEAR(truth.back().attitude->yaw_rad, 0.1, 1e-9);
  EXPECT_EQ(report()["frames"].size(), 3U * kStations + 1);
}

TEST_F(RectifySetTest, MasksOfFramesAreJoinedWithThatOfAll) {
  WithHeldOut more(*set_, *poses_, out_.path(), *room_);
  cv::Mat own(kSize.height, kSize.width, CV_8UC1, cv::Scalar(1));
  own(cv::Rect(kSize.width / 2 - 8, kSize.height / 2 - 8, 16, 16)) = cv::Scalar(0);
  const fs::path file = in_out("masks/own.png");  // the user's folder, which stays
  make_directories(directory_of(file));
  write_image(file, own);
  more.set.frames[0].mask = file;
  more.set.frames[3 * kStations].mask = file;
  const RectifyResult result = rectify_set(more.set, more.poses, options());
  EXPECT_EQ(result.masks.frames, 2);
  EXPECT_NEAR(result.masks.share, 256.0 / (256.0 * 128.0) * kHalfPi, 1e-3);
  const std::vector<Frame> listed = read_frame_list(in_out("poses.csv"));
  ASSERT_TRUE(listed[0].mask);
  EXPECT_FALSE(listed[1].mask);
  EXPECT_TRUE(read_frame_list(in_out("gt.csv")).back().mask);
  RectifyOptions joined = options();
  joined.mask = cv::Mat(kSize.height, kSize.width, CV_8UC1, cv::Scalar(255));
  joined.mask->rowRange(120, 128).setTo(0);
  rectify_set(more.set, more.poses, joined);
  const std::vector<Frame> again = read_frame_list(in_out("poses.csv"));
  const cv::Mat both = read_mask(*again[0].mask, kSize);
  EXPECT_EQ(both.at<uchar>(kSize.height / 2, kSize.width / 2), 0);
  EXPECT_EQ(both.at<uchar>(127, 0), 0);
  ASSERT_TRUE(again[1].mask);
  EXPECT_EQ(read_mask(*again[1].mask, kSize).at<uchar>(kSize.height / 2, kSize.width / 2), 255);
  EXPECT_TRUE(fs::exists(file));
}

}  // namespace
}  // namespace raywalk::calibrate
