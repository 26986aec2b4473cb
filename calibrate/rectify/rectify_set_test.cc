// Lists of captured panoramas against the ray-traced truth, and overlays where lines cross.
#include "calibrate/rectify/rectify_set.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calibrate/base/frame_masks.h"
#include "calibrate/base/test_lines.h"
#include "calibrate/rectify/intersection_overlay.h"
#include "calibrate/rectify/rectified_frames.h"
#include "calibrate/stitch/stitch_record.h"
#include "calibrate/stitch/stitch_set.h"
#include "calibrate/stitch/stitch_test_camera.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"
#include "core/panorama/panorama_rotation.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr PanoramaSize kSize{256, 128};
constexpr int kStations = 4;

// Two intersecting lines and a validation line, with another attitude at every station; taken once
// for all tests.
struct Captured {
  TestDirectory folder{};
  simulator::VirtualRoom room{simulator::VirtualRoomSettings{}};
  CaptureSet set{};
  FramePoses poses{};

  Captured() {
    set.source = folder.path();
    set.frame = kSize;
    add_test_line(&set, "x0", LineAxis::kX, 0.0, 0.15, kStations);
    add_test_line(&set, "z0", LineAxis::kZ, 0.0, 0.15, kStations);
    add_test_line(&set, "v0", LineAxis::kX, 0.1, 0.15, kStations);
    set.lines[2].validation = true;
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      CaptureFrame& frame = set.frames[i];
      const int station = static_cast<int>(i) % kStations;
      const Attitude attitude{0.02 * (frame.line + 1), -0.01 * station,
                              0.015 * (station - frame.line)};
      poses.emplace_back(
          FramePose{.position_m = frame.nominal_m + Eigen::Vector3d(0.001, 0.002, -0.0015),
                    .world_from_camera = world_from_camera(attitude),
                    .origin = PoseOrigin::kSolved});
      frame.file = folder / (frame.name + ".png");
      write_image(frame.file,
                  room.render(simulator::PanoramaRays(kSize), {poses[i]->position_m, attitude}));
    }
  }
};

const Captured& captured() {
  static const Captured lines;
  return lines;
}

class RectifySetTest : public ::testing::Test {
 protected:
  RectifyOptions options() const { return {.out = out_.path() / "calibration"}; }
  fs::path in_out(const std::string& file) const { return out_.path() / "calibration" / file; }
  std::vector<Frame> listed_in(const std::string& list) const {
    return read_frame_list(in_out(list));
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(in_out("rectify.json"))); }
  // Mean PSNR over the frames of a list, in world axes, against upright ground truth where they
  // were taken. The list has the order of the set.
  double mean_psnr_db(const std::string& list, std::size_t first) const {
    double sum = 0.0;
    const std::vector<Frame> frames = listed_in(list);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const cv::Mat truth = captured().room.render(simulator::PanoramaRays(kSize),
                                                   {poses_[first + i]->position_m, {}});
      sum += psnr_db(truth,
                     rotate_panorama(read_panorama(frames[i].path),
                                     world_from_camera(frames[i].attitude.value_or(Attitude{}))));
    }
    return sum / static_cast<double>(frames.size());
  }

  // A frame between the stations that is no station, and one that has no pose.
  void add_held_out() {
    const Attitude attitude{0.1, 0.0, 0.02};
    const FramePose pose{.position_m = {0.02, 0.0, 0.03},
                         .world_from_camera = world_from_camera(attitude)};
    const cv::Mat seen =
        captured().room.render(simulator::PanoramaRays(kSize), {pose.position_m, attitude});
    for (const std::string name : {"t0", "unposed"}) {
      const fs::path file = out_ / (name + ".png");
      write_image(file, seen);
      set_.frames.push_back({.name = name,
                             .line = kHeldOut,
                             .file = file,
                             .nominal_m = pose.position_m,
                             .where = "gt.csv:2"});
    }
    poses_.emplace_back(pose);
    poses_.emplace_back(std::nullopt);
  }

  TestDirectory out_;
  CaptureSet set_ = captured().set;
  FramePoses poses_ = captured().poses;
};

TEST_F(RectifySetTest, ListsHoldThePosesAndTheValidationLineApart) {
  const RectifyResult result = rectify_set(set_, poses_, options());
  EXPECT_EQ(result.frames, 2 * kStations);
  EXPECT_EQ(result.validation_frames, kStations);
  EXPECT_TRUE(result.left_out.empty());
  const std::vector<Frame> listed = listed_in("poses.csv"), truth = listed_in("gt.csv");
  ASSERT_EQ(listed.size(), 2U * kStations);
  EXPECT_EQ(listed[0].path, set_.frames[0].file);
  EXPECT_LT((listed[0].position_m - poses_[0]->position_m).norm(), 1e-8);
  EXPECT_FALSE(listed[0].mask);
  EXPECT_EQ(listed[0].line, "x0");
  ASSERT_EQ(truth.size(), 1U * kStations);
  EXPECT_EQ(truth[0].path, set_.frames[2 * kStations].file);
  EXPECT_FALSE(fs::exists(in_out("rectified")));
  // Panoramas of 256 pixels resampled once have 31 dB against upright ray-traced ones.
  EXPECT_GT(mean_psnr_db("poses.csv", 0), 29.0);
  EXPECT_GT(mean_psnr_db("gt.csv", 2 * kStations), 29.0);
  EXPECT_LT(mean_psnr_db("before.csv", 0), 24.0);
}

// A capture and its calibration are moved together.
TEST_F(RectifySetTest, PicturesBesideTheCalibrationAreNamedRelativeToIt) {
  const RectifyOptions beside{.out = captured().folder / "calibration"};
  rectify_set(set_, poses_, beside);
  EXPECT_EQ(read_frame_list(beside.out / "poses.csv")[0].file, "../x0_0.png");
  fs::remove_all(beside.out);
}

TEST_F(RectifySetTest, OverlaysShowTheLinesAgree) {
  const RectifyResult result = rectify_set(set_, poses_, options());
  ASSERT_GE(result.intersections.size(), 1U);
  for (const IntersectionComparison& intersection : result.intersections) {
    EXPECT_LT(intersection.difference_after, 0.8 * intersection.difference_before);
    EXPECT_TRUE(fs::exists(in_out(intersection.after.string())));
  }
  const auto written = report();
  expect_keys(written, {{"grid_frames", result.frames},
                        {"line_tolerance_mm", result.line_tolerance_mm.value()},
                        {"same_station_mm", nullptr},
                        {"frame_masks", nullptr},
                        {"before_list", in_out("before.csv").string()}});
  EXPECT_EQ(written["frames"][3]["file"], set_.frames[3].file.string());
  ASSERT_EQ(written["intersections"].size(), result.intersections.size());
  EXPECT_EQ(written["figures"][0]["file"], result.intersections[0].before.generic_string());
  EXPECT_THAT(written["figures"][0]["row"], StartsWith("x0 × z0, frames x0_"));
  EXPECT_THAT(written["figures"][1]["caption"], StartsWith("after: differ by "));
}

TEST_F(RectifySetTest, FramesWithoutAPoseAreLeftOut) {
  // Lines are compared at their nearest stations with a pose.
  for (int i = 0; i < kStations; ++i) poses_[kStations + i]->position_m.z() += 0.01;
  poses_[1].reset();
  EXPECT_THAT(rectify_set(set_, poses_, options()).left_out, ElementsAre("x0_1"));
  EXPECT_THAT(report()["left_out"], ElementsAre("x0_1"));
  EXPECT_EQ(report()["figures"][0]["row"], "x0 × z0, frames x0_2 and z0_1");
  // The list of the frames before the calibration has the same stations.
  const std::vector<Frame> listed = listed_in("poses.csv"), before = listed_in("before.csv");
  ASSERT_EQ(listed.size(), 2U * kStations - 1);
  ASSERT_EQ(before.size(), listed.size());
  EXPECT_EQ(before[0].path, set_.frames[0].file);
  EXPECT_EQ(before[1].path, set_.frames[2].file);
  EXPECT_LT((before[1].position_m - set_.frames[2].nominal_m).norm(), 1e-8);
  for (auto& pose : poses_) pose.reset();
  EXPECT_THROW(rectify_set(set_, poses_, options()), Error);
}

TEST_F(RectifySetTest, HeldOutFramesAreListedApartFromTheStations) {
  const RectifyResult alone = rectify_set(set_, poses_, options());
  const std::string stations = read_file(in_out("poses.csv"));
  add_held_out();
  const CapturedLog log;
  const RectifyResult result = rectify_set(set_, poses_, options());
  EXPECT_THAT(log.text(), HasSubstr("held-out frame unposed has no pose"));
  EXPECT_THAT(result.left_out, ElementsAre("unposed"));
  EXPECT_EQ(result.frames, alone.frames);
  EXPECT_EQ(result.validation_frames, kStations + 1);
  EXPECT_EQ(read_file(in_out("poses.csv")), stations);
  const std::vector<Frame> truth = listed_in("gt.csv");
  ASSERT_EQ(truth.size(), 1U * kStations + 1);
  EXPECT_TRUE(fs::equivalent(truth.back().path, out_ / "t0.png"));
  EXPECT_NEAR(truth.back().attitude.value().yaw_rad, 0.1, 1e-9);
  EXPECT_EQ(report()["frames"].size(), 3U * kStations + 1);
}

TEST_F(RectifySetTest, MasksOfFramesAreJoinedWithThatOfAll) {
  add_held_out();
  cv::Mat own(kSize.height, kSize.width, CV_8UC1, cv::Scalar(1));
  own(cv::Rect(kSize.width / 2 - 8, kSize.height / 2 - 8, 16, 16)) = cv::Scalar(0);
  const fs::path file = in_out("masks/own.png");  // the user's folder, which stays
  make_directories(directory_of(file));
  write_image(file, own);
  set_.frames[0].mask = file;
  set_.frames[3 * kStations].mask = file;
  const RectifyResult result = rectify_set(set_, poses_, options());
  EXPECT_EQ(result.masks.frames, 2);
  EXPECT_EQ(report()["frame_masks"]["frames"], 2);
  EXPECT_NEAR(result.masks.share, 256.0 / (256.0 * 128.0) * kHalfPi, 1e-3);
  const std::vector<Frame> listed = listed_in("poses.csv");
  ASSERT_TRUE(listed[0].mask);
  EXPECT_FALSE(listed[1].mask);
  EXPECT_TRUE(listed_in("gt.csv").back().mask);
  EXPECT_THAT(read_file(in_out("before.csv")), HasSubstr(",masks/own.png,x0\n"));
  RectifyOptions joined = options();
  joined.mask = cv::Mat(kSize.height, kSize.width, CV_8UC1, cv::Scalar(255));
  joined.mask->rowRange(120, 128).setTo(0);
  rectify_set(set_, poses_, joined);
  const std::vector<Frame> again = listed_in("poses.csv");
  const cv::Mat both = read_mask(*again[0].mask, kSize);
  EXPECT_EQ(both.at<uchar>(kSize.height / 2, kSize.width / 2), 0);
  EXPECT_EQ(both.at<uchar>(127, 0), 0);
  ASSERT_TRUE(again[1].mask);
  EXPECT_EQ(read_mask(*again[1].mask, kSize).at<uchar>(kSize.height / 2, kSize.width / 2), 255);
  EXPECT_TRUE(fs::exists(file));
}

// That of the capture is needed only where the default of `pack` fails.
TEST_F(RectifySetTest, TolerancesArePassedOn) {
  RectifyOptions tolerant = options();
  tolerant.tolerance = {.off_line_m = 0.08, .same_station_m = 0.002};
  const std::string command =
      "raywalk-build-lf all --frames " + in_out("poses.csv").string() + " --out ROOM.lf";
  EXPECT_EQ(rectify_set(set_, poses_, tolerant).line_tolerance_mm, 0.0);
  EXPECT_EQ(report()["next_command"], command + " --same-station-mm 2");
  for (const int i : {0, 2}) poses_[i]->position_m.z() += 0.06;
  EXPECT_EQ(rectify_set(set_, poses_, tolerant).line_tolerance_mm, 80.0);
  EXPECT_EQ(report()["next_command"], command + " --line-tolerance-mm 80 --same-station-mm 2");
  // Where none is enough, as where there is no grid at all, that is not an error.
  EXPECT_FALSE(rectify_set(set_, poses_, options()).line_tolerance_mm);
  EXPECT_EQ(report()["next_command"], command);
  for (std::size_t i = 1; i < poses_.size(); ++i) poses_[i].reset();
  EXPECT_FALSE(rectify_set(set_, poses_, options()).line_tolerance_mm);
}

// Grey, with stripes over an eighth of the width that starts at column `left`.
cv::Mat panorama_with_stripes(int left) {
  cv::Mat panorama(64, 128, CV_8UC3, cv::Scalar(100, 100, 100));
  for (int u = 0; u < 16; ++u) {
    if (u % 4 < 2) panorama.col((left + u) % 128) = cv::Scalar(200, 200, 200);
  }
  return panorama;
}

TEST(IntersectionOverlayTest, WindowHasTheMostTexture) {
  for (const int left : {0, 40, 120}) {
    const HorizonWindow window = most_textured_window(panorama_with_stripes(left));
    EXPECT_EQ(window.width, 32);
    const int into = (left - window.left + 128) % 128;
    EXPECT_LE(into, 16) << left;  // all sixteen columns within the window
    EXPECT_EQ(window.top, (64 - window.height) / 2);
  }
}

TEST(IntersectionOverlayTest, PicturesThatAgreeAreGrey) {
  const cv::Mat panorama = panorama_with_stripes(120);
  const HorizonWindow window = most_textured_window(panorama);
  const Overlay same = overlay_of(panorama, panorama, window);
  EXPECT_EQ(same.difference_levels, 0.0);
  const auto red_from_blue = [](const Overlay& overlay) {
    std::vector<cv::Mat> channels;
    cv::split(overlay.picture, channels);
    return cv::norm(channels[0], channels[2], cv::NORM_INF);
  };
  EXPECT_EQ(red_from_blue(same), 0.0);
  const Overlay moved = overlay_of(panorama, panorama_with_stripes(122), window);
  EXPECT_GT(moved.difference_levels, 10.0);
  EXPECT_EQ(red_from_blue(moved), 100.0);
}

// Most texture, and all of the difference, is where a mask hides it.
TEST(IntersectionOverlayTest, MaskedPixelsAreNotCompared) {
  cv::Mat first(90, 180, CV_8UC3, cv::Scalar::all(100)), valid(90, 180, CV_8UC1, cv::Scalar(255));
  for (int u = 0; u < 20; ++u) first.col(20 + 2 * u).setTo(cv::Scalar::all(200));
  first.col(130).setTo(cv::Scalar::all(120));
  cv::Mat second = first.clone();
  second.colRange(0, 70).setTo(cv::Scalar::all(0));
  valid.colRange(0, 70).setTo(0);
  const HorizonWindow window = most_textured_window(first, valid);
  EXPECT_TRUE(window.left <= 130 && 130 < window.left + window.width) << window.left;
  const HorizonWindow partly_masked{40, 45, 35, 20};
  EXPECT_EQ(overlay_of(first, second, partly_masked, valid).difference_levels, 0.0);
  EXPECT_GT(overlay_of(first, second, partly_masked).difference_levels, 50.0);
  valid.setTo(0);
  EXPECT_TRUE(std::isnan(overlay_of(first, second, window, valid).difference_levels));
}

// --- Fisheye pictures rectified once, against the truth and rotated panoramas --------------------

constexpr int kFisheyeFrames = 3;

Attitude attitude_of(int frame) { return {0.3 + 0.4 * frame, 0.1 - 0.09 * frame, 0.05 * frame}; }

Eigen::Vector3d position_of(int frame) { return {0.06 * frame - 0.05, 0.0, 0.1}; }

// Without lens parallax, so that every difference from the truth is one of sampling.
const DualFisheyeCamera& fisheye_camera() {
  static const DualFisheyeCamera camera = test_camera(440, 0.0);
  return camera;
}

const std::vector<cv::Mat>& fisheye_pictures() {
  static const std::vector<cv::Mat> pictures = [] {
    const simulator::DualFisheyeRays rays(fisheye_camera().layout, fisheye_camera().picture);
    std::vector<cv::Mat> made;
    for (int i = 0; i < kFisheyeFrames; ++i) {
      made.push_back(test_room().render(rays, {position_of(i), attitude_of(i)}));
    }
    return made;
  }();
  return pictures;
}

class RectifiedFisheyeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    captured_ = fisheye_line(directory_.path(), fisheye_pictures());
    for (int i = 0; i < kFisheyeFrames; ++i) {
      captured_.frames[i].nominal_m = position_of(i);
      poses_.emplace_back(FramePose{.position_m = position_of(i),
                                    .world_from_camera = world_from_camera(attitude_of(i)),
                                    .origin = PoseOrigin::kSolved});
    }
  }

  void stitch(int width) {
    panoramas_ = stitch_set(captured_, fisheye_camera(),
                            {.width = width, .balance = false, .out = directory_ / "out"});
    source_ = read_fisheye_source(captured_, fisheye_camera(), directory_ / "out");
  }

  // Rectifies into a directory of that name.
  void rectify(const std::string& name, const FramePoses& poses, const cv::Mat& mask = {}) const {
    make_directories(directory_ / name);
    write_rectified_frames(source_, panoramas_, poses, mask, directory_ / name);
  }
  cv::Mat mask_in(const std::string& name, int frame) const {
    return read_mask(directory_ / name / rectified_mask_file(captured_.frames[frame]),
                     panoramas_.frame);
  }

  TestDirectory directory_;
  CaptureSet captured_{}, panoramas_{};
  FisheyeSource source_{};
  FramePoses poses_{};
};

TEST_F(RectifiedFisheyeTest, OneResamplingIsCloserToTheTruthThanTwo) {
  stitch(default_panorama_width(fisheye_camera()));
  rectify("once", poses_);
  double once_db = 0.0, twice_db = 0.0;
  for (std::size_t i = 0; i < kFisheyeFrames; ++i) {
    const FramePose& pose = *poses_[i];
    const cv::Mat truth =
        test_room().render(simulator::PanoramaRays(panoramas_.frame), {pose.position_m, {}});
    const cv::Mat once = read_panorama(directory_ / "once" / rectified_file(captured_.frames[i]));
    once_db += psnr_db(once, truth) / kFisheyeFrames;
    const cv::Mat stitched = read_panorama(panoramas_.frames[i].file);
    twice_db += psnr_db(rotate_panorama(stitched, pose.world_from_camera), truth) / kFisheyeFrames;
  }
  // Measured: 38.6 and 37.5 dB; a rotation wrong by 0.2 degrees would give 34.1.
  EXPECT_GT(once_db, twice_db + 0.7);
}

// A visitor before the front lens of one frame, the dolly below all.
TEST_F(RectifiedFisheyeTest, MasksAreTurnedWithTheirFrames) {
  cv::Mat own(fisheye_camera().picture.height, fisheye_camera().picture.width, CV_8UC1,
              cv::Scalar(255));
  const PixelPosition centre = fisheye_camera().layout.front.centre;
  cv::circle(own, {static_cast<int>(centre.u), static_cast<int>(centre.v)}, 20, cv::Scalar(0),
             cv::FILLED);
  write_image(directory_ / "own.png", own);
  captured_.frames[1].mask = directory_ / "own.png";
  stitch(512);
  poses_[1]->world_from_camera = world_from_camera({radians_from_degrees(30.0), 0.0, 0.0});
  cv::Mat dolly(panoramas_.frame.height, panoramas_.frame.width, CV_8UC1, cv::Scalar(255));
  dolly.rowRange(230, 256).setTo(0);
  rectify("once", poses_, dolly);
  const int right = 256 + 512 * 30 / 360;
  for (int frame = 0; frame < kFisheyeFrames; ++frame) {
    const cv::Mat mask = mask_in("once", frame);
    const bool visited = frame == 1;
    EXPECT_EQ(mask.at<uchar>(128, right), visited ? 0 : 255) << frame;
    EXPECT_EQ(mask.at<uchar>(128, right - 40), 255) << frame;
    EXPECT_EQ(mask.at<uchar>(255, 100), 0) << frame;
    // Only edges differ, where the mask of the panoramas was widened twice.
    const cv::Mat twice =
        rotate_mask(joint_mask(panoramas_, frame, dolly), poses_[frame]->world_from_camera);
    const cv::Mat differs = mask != twice;
    EXPECT_LT(cv::countNonZero(differs), visited ? 0.2 * cv::countNonZero(mask == 0) : 1) << frame;
  }
  // Without the dolly only the visited frame has a mask.
  rectify("visited", poses_);
  EXPECT_TRUE(fs::exists(directory_ / "visited/rectified/masks/x0_1.png"));
  EXPECT_FALSE(fs::exists(directory_ / "visited/rectified/masks/x0_0.png"));
  own.setTo(0);
  own.at<uchar>(static_cast<int>(centre.v), static_cast<int>(centre.u)) = 255;
  write_image(directory_ / "own.png", own);
  EXPECT_THAT(error_of([&] { rectify("visited", poses_); }),
              HasSubstr("of what the mask of frame x0_1 leaves, nothing remains"));
}

// A frame that cannot be read stops the run; finished frames are kept only for the same inputs.
TEST_F(RectifiedFisheyeTest, FramesAreMadeAnewWhenTheirInputsChange) {
  stitch(256);
  const fs::path last = captured_.frames.back().file;
  const std::string whole = read_file(last);
  write_file_atomically(last, std::string("no picture"));
  const fs::path first = directory_ / "out/rectified.partial/x0_0.png";
  const auto made_at = [&] {
    EXPECT_THROW(rectify("out", poses_), Error);
    EXPECT_TRUE(fs::exists(first));
    return fs::last_write_time(first);
  };
  auto made = made_at();
  EXPECT_EQ(made_at(), made);
  const auto expect_anew_after = [&](const auto& change) {
    change();
    const auto now = made_at();
    EXPECT_NE(std::exchange(made, now), now);
  };
  expect_anew_after([&] { source_.camera.layout.front.focal_px += 0.1; });
  expect_anew_after([&] { source_.back_gain[1] = 1.01; });
  expect_anew_after([&] { source_.camera.falloff_2 = -0.01; });
  expect_anew_after([&] { source_.options.blend_deg = 3.0; });
  expect_anew_after([&] { write_image(captured_.frames[0].file, fisheye_pictures()[1]); });
  EXPECT_EQ(made_at(), made);
  write_file_atomically(last, whole);
  rectify("out", poses_);
  EXPECT_TRUE(fs::exists(directory_ / "out/rectified/x0_0.png"));
}

TEST_F(RectifiedFisheyeTest, AMissingOrUnfinishedStitchIsNamed) {
  const auto message = [&] {
    return error_of([&] { read_fisheye_source(captured_, fisheye_camera(), directory_ / "out"); });
  };
  EXPECT_THAT(message(), HasSubstr("stitch.json: missing"));
  stitch(256);
  EXPECT_EQ(source_.width, 256);
  EXPECT_EQ(message(), "no error");
  std::string text = read_file(directory_ / "out/stitch.json");
  text.replace(text.find("\"complete\": true"), 16, "\"complete\": false");
  write_file_atomically(directory_ / "out/stitch.json", text);
  EXPECT_THAT(message(), HasSubstr("run raywalk-calibrate stitch"));
}

}  // namespace
}  // namespace raywalk::calibrate
