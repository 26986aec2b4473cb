#include "calibrate/mask/dolly_detection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/test_error.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using testing::HasSubstr;

constexpr PanoramaSize kDollySize{360, 180};

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
    set.frame = kDollySize;
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
    cv::Mat panorama(kDollySize.height, kDollySize.width, CV_8UC3);
    for (int v = 0; v < kDollySize.height; ++v) {
      for (int u = 0; u < kDollySize.width; ++u) {
        const Eigen::Vector3d direction =
            direction_from_angles(angles_from_pixel({double(u), double(v)}, kDollySize));
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
    for (int v = 0; v < kDollySize.height; ++v) {
      const double from_nadir =
          90.0 + degrees_from_radians(angles_from_pixel({0.0, double(v)}, kDollySize).phi_rad);
      const int valid = cv::countNonZero(found->mask.row(v));
      if (from_nadir < dolly_deg) {
        EXPECT_EQ(valid, 0) << from_nadir;
      } else if (from_nadir > dolly_deg + 5.0) {
        EXPECT_EQ(valid, kDollySize.width) << from_nadir;
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
    cv::Mat mask(kDollySize.height, kDollySize.width, CV_8UC1, cv::Scalar(255));
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
  cv::Mat mask(kDollySize.height, kDollySize.width, CV_8UC1, cv::Scalar(255));
  mask.rowRange(160, kDollySize.height).setTo(0);
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
