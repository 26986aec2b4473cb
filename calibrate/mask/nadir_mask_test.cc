#include "calibrate/mask/nadir_mask.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "calibrate/base/frame_masks.h"
#include "calibrate/mask/dolly_detection.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_json.h"
#include "core/files/test_support.h"
#include "core/geometry/test_pixels.h"

namespace raywalk::calibrate {
namespace {

using testing::HasSubstr;

constexpr PanoramaSize kMaskSize{360, 180};

Eigen::Vector3d direction_of(int u, int v) {
  return direction_from_angles(angles_from_pixel({double(u), double(v)}, kMaskSize));
}

MaskOptions cone(double cone_deg) { return {.cone_deg = cone_deg}; }

std::string message_of(const MaskOptions& options) {
  return error_of([&] { make_mask(kMaskSize, options); });
}

class NadirMaskTest : public testing::Test {
 protected:
  MaskOptions with_picture(const cv::Mat& picture) {
    write_image(directory_ / "picture.png", picture);
    return {.picture = directory_ / "picture.png", .out = directory_ / "out"};
  }

  CaptureSet one_panorama() {
    write_image(directory_ / "a.png", cv::Mat(180, 360, CV_8UC3, cv::Scalar(10, 200, 30)));
    CaptureSet set;
    set.frame = kMaskSize;
    set.frames = {{.name = "a", .file = directory_ / "a.png"}};
    set.lines = {{.id = "x0", .frames = {0}}};
    return set;
  }

  TestDirectory directory_;
};

TEST_F(NadirMaskTest, ConeHidesDirectionsWithinItsAngleOfTheNadir) {
  for (const double angle_deg : {1.0, 22.5, 60.0, 89.0}) {
    const cv::Mat mask = make_mask(kMaskSize, cone(angle_deg));
    for (const auto [u, v] : pixels_of(kMaskSize)) {
      const double from_nadir_deg = degrees_from_radians(std::acos(-direction_of(u, v).y()));
      ASSERT_EQ(mask.at<unsigned char>(v, u), from_nadir_deg < angle_deg ? 0 : 255);
    }
  }
  for (const double angle_deg : {-1.0, 89.5, std::nan("")}) {
    EXPECT_THROW(make_mask(kMaskSize, cone(angle_deg)), UsageError);
  }
}

TEST_F(NadirMaskTest, NoOptionsMaskNothing) {
  EXPECT_EQ(cv::countNonZero(make_mask(kMaskSize, {})), kMaskSize.width * kMaskSize.height);
  EXPECT_FALSE(write_mask(one_panorama(), {.out = directory_ / "out"}));
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out"));
}

TEST_F(NadirMaskTest, PictureOfAnotherSizeIsScaledAndAddsToTheCone) {
  cv::Mat picture(90, 180, CV_8UC1, cv::Scalar(255));
  picture(cv::Rect(20, 30, 40, 20)).setTo(3);  // as JPEG leaves black
  MaskOptions options = with_picture(picture);
  options.cone_deg = 5.0;
  const cv::Mat mask = make_mask(kMaskSize, options);
  EXPECT_EQ(cv::countNonZero(mask == 0), 80 * 40 + 5 * kMaskSize.width);
  EXPECT_EQ(mask.at<unsigned char>(60, 40), 0);
  EXPECT_EQ(mask.at<unsigned char>(99, 119), 0);
  EXPECT_EQ(mask.at<unsigned char>(59, 40), 255);
  EXPECT_EQ(mask.at<unsigned char>(99, 120), 255);
}

TEST_F(NadirMaskTest, WritesMaskAndFigure) {
  const MaskOptions options{.cone_deg = 30.0, .out = directory_ / "out"};
  const auto mask = write_mask(one_panorama(), options);
  ASSERT_TRUE(mask);
  EXPECT_EQ(cv::norm(read_mask(options.out / "mask.png", kMaskSize), *mask, cv::NORM_INF), 0.0);
  const auto json = nlohmann::json::parse(read_file(options.out / "mask.json"));
  expect_keys(json, {{"cone_deg", 30.0},
                     {"frame_masks", nullptr},
                     {"picture", nullptr},
                     {"automatic", nullptr},
                     {"station", "a"}});
  EXPECT_NEAR(json.at("masked_share").get<double>(), 0.067, 0.001);
  // Red where it is masked: straight down.
  EXPECT_EQ(json.at("figures")[0].at("row"), "Station a");
  const cv::Mat shown = read_picture(options.out / json.at("figures")[0].at("file"));
  const auto below = shown.at<cv::Vec3b>(shown.rows - 1, 0), above = shown.at<cv::Vec3b>(0, 0);
  EXPECT_GT(below[2], above[2] + 50);
  // Without a cone there is no mask, also none of an earlier run.
  EXPECT_FALSE(write_mask(one_panorama(), {.out = options.out}));
  for (const char* file : {"mask.png", "mask.json", "figures/mask.png"}) {
    EXPECT_FALSE(std::filesystem::exists(options.out / file)) << file;
  }
}

TEST_F(NadirMaskTest, ReportTellsOfMasksOfSingleFrames) {
  CaptureSet set = one_panorama();
  cv::Mat own(kMaskSize.height, kMaskSize.width, CV_8UC1, cv::Scalar(255));
  own.rowRange(0, kMaskSize.height / 2).setTo(0);
  set.frames[0].mask = directory_ / "own.png";
  write_image(*set.frames[0].mask, own);
  const MaskOptions options{.cone_deg = 30.0, .out = directory_ / "out"};
  const auto mask = write_mask(set, options);
  ASSERT_TRUE(mask);
  EXPECT_EQ(mask->at<uchar>(0, 0), 255);  // that of all frames is as without
  const auto masks = [&] {
    return nlohmann::json::parse(read_file(options.out / "mask.json")).at("frame_masks");
  };
  expect_keys(masks(), {{"frames", 1}, {"of_frames", 1}});
  EXPECT_NEAR(masks().at("masked_share").get<double>(), 0.567, 0.001);
  // Also without a mask of all frames, of which there is then no file.
  EXPECT_FALSE(write_mask(set, {.out = options.out}));
  EXPECT_FALSE(std::filesystem::exists(options.out / "mask.png"));
  EXPECT_NEAR(masks().at("masked_share").get<double>(), 0.5, 5e-5);
}

TEST_F(NadirMaskTest, MasksOfEverythingAndInvalidPicturesAreRefused) {
  EXPECT_THAT(message_of(with_picture(cv::Mat(90, 180, CV_8UC1, cv::Scalar(0)))),
              HasSubstr("hides everything"));
  EXPECT_THROW(write_mask(one_panorama(), with_picture(cv::Mat(90, 180, CV_8UC1, cv::Scalar(0)))),
               Error);
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out"));
  EXPECT_THAT(message_of(with_picture(cv::Mat(100, 180, CV_8UC1, cv::Scalar(255)))),
              HasSubstr("picture.png: 180x100 is not a panorama"));
  EXPECT_THAT(message_of(with_picture(cv::Mat(90, 180, CV_8UC3, cv::Scalar::all(255)))),
              HasSubstr("not an 8-bit grey image"));
  EXPECT_THAT(message_of({.picture = directory_ / "nowhere.png"}), HasSubstr("nowhere.png"));
  CaptureSet fisheyes = one_panorama();
  fisheyes.layout = FrameLayout::kDualFisheye;
  EXPECT_THROW(write_mask(fisheyes, cone(20.0)), Error);
}

// A floor one metre below the camera with a random pattern, and grey walls above the horizon.
struct Floor {
  double pattern_from_x = -2.0;  // directions with less are over a plain floor
  double dolly_deg = 20.0;       // of a disc under the camera; 0: none
};

double pattern_at(double x_m, double z_m) {
  return 128.0 + 40.0 * std::sin(17.0 * x_m + 3.0 * std::sin(11.0 * z_m)) +
         40.0 * std::sin(13.0 * z_m + 2.0 * std::sin(19.0 * x_m));
}

class DollyDetectionTest : public testing::Test {
 protected:
  CaptureSet line_of(int stations, const Floor& floor) {
    CaptureSet set;
    set.frame = kMaskSize;
    set.lines = {{.id = "x0"}};
    cv::RNG random(5);
    for (int i = 0; i < stations; ++i) {
      const std::string name = "s" + std::to_string(i);
      // Exposure drifts by some per cent.
      write_image(directory_ / (name + ".png"),
                  seen_from(0.05 * i, floor, random.uniform(0.95, 1.05), &random));
      set.lines[0].frames.push_back(i);
      set.frames.push_back({.name = name, .file = directory_ / (name + ".png")});
    }
    return set;
  }

 private:
  static cv::Mat seen_from(double x_m, const Floor& floor, double gain, cv::RNG* random) {
    cv::Mat panorama(kMaskSize.height, kMaskSize.width, CV_8UC3);
    for (const auto [u, v] : pixels_of(kMaskSize)) {
      const Eigen::Vector3d direction = direction_of(u, v);
      double level = 150.0;
      if (direction.y() < -0.05) {
        const double from_nadir = degrees_from_radians(std::acos(-direction.y()));
        if (from_nadir < floor.dolly_deg) {
          level = std::fmod(from_nadir, 6.0) < 3.0 ? 60.0 : 90.0;
        } else if (direction.x() > floor.pattern_from_x) {
          level = pattern_at(x_m - direction.x() / direction.y(), -direction.z() / direction.y());
        }
      }
      for (int c = 0; c < 3; ++c) {
        panorama.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<unsigned char>(gain * level + random->gaussian(1.0));
      }
    }
    return panorama;
  }

  TestDirectory directory_;
};

TEST_F(DollyDetectionTest, FindsWhatMovesWithTheCamera) {
  for (const double dolly_deg : {12.0, 25.0}) {
    const auto found = detect_dolly(line_of(12, {.dolly_deg = dolly_deg}));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->stations, 12);
    EXPECT_NEAR(found->reach_deg, dolly_deg + 2.0, 2.0);
    for (int v = 0; v < kMaskSize.height; ++v) {
      const double from_nadir =
          90.0 + degrees_from_radians(angles_from_pixel({0.0, double(v)}, kMaskSize).phi_rad);
      const int valid = cv::countNonZero(found->mask.row(v));
      if (from_nadir < dolly_deg) {
        EXPECT_EQ(valid, 0) << from_nadir;
      } else if (from_nadir > dolly_deg + 5.0) {
        EXPECT_EQ(valid, kMaskSize.width) << from_nadir;
      }
    }
  }
}

// Somebody stands still beside the dolly at most stations, and their masks say so.
TEST_F(DollyDetectionTest, WhatTheFramesMaskIsNotLookedAt) {
  CaptureSet set = line_of(20, {.dolly_deg = 12.0});
  const cv::Rect person(0, 135, 60, 45);  // to the back left, up to 45 degrees from the nadir
  for (std::size_t i = 0; i < 12; ++i) {
    cv::Mat picture = read_panorama(set.frames[i].file);
    picture(person).setTo(cv::Scalar::all(30));
    write_image(set.frames[i].file, picture);
    cv::Mat mask(kMaskSize.height, kMaskSize.width, CV_8UC1, cv::Scalar(255));
    mask(person).setTo(0);
    set.frames[i].mask = set.frames[i].file.string() + "_mask.png";
    write_image(*set.frames[i].mask, mask);
  }
  const auto found = detect_dolly(set);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->reach_deg, 14.0, 2.0);
  // The other eight stations see the floor there, which moves, and the dolly, which does not.
  EXPECT_EQ(found->mask.at<uchar>(145, 30), 255);
  EXPECT_EQ(found->mask.at<uchar>(171, 30), 0);
  EXPECT_EQ(found->mask.at<uchar>(175, 200), 0);
}

TEST_F(DollyDetectionTest, NothingIsLookedForBelowMasksOfTheNadir) {
  CaptureSet set = line_of(10, {.dolly_deg = 20.0});
  cv::Mat mask(kMaskSize.height, kMaskSize.width, CV_8UC1, cv::Scalar(255));
  mask.rowRange(160, kMaskSize.height).setTo(0);
  for (CaptureFrame& frame : set.frames) {
    frame.mask = frame.file.string() + "_mask.png";
    write_image(*frame.mask, mask);
  }
  EXPECT_FALSE(detect_dolly(set));
}

TEST_F(DollyDetectionTest, NothingIsFoundOnABareFloorOrIfNothingMoves) {
  EXPECT_FALSE(detect_dolly(line_of(10, {.dolly_deg = 0.0})));
  EXPECT_FALSE(detect_dolly(line_of(10, {.pattern_from_x = 2.0})));
}

TEST_F(DollyDetectionTest, FloorsWithoutTextureAndShortLinesAreErrors) {
  EXPECT_THAT(error_of([&] { detect_dolly(line_of(10, {.pattern_from_x = -0.1})); }),
              HasSubstr("floor without texture"));
  EXPECT_THAT(error_of([&] { detect_dolly(line_of(7, {})); }), HasSubstr("8 stations"));
}

}  // namespace
}  // namespace raywalk::calibrate
