#include "calibrate/mask/nadir_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/frame_masks.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using testing::HasSubstr;

constexpr PanoramaSize kMaskSize{360, 180};

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
    for (int v = 0; v < kMaskSize.height; ++v) {
      for (int u = 0; u < kMaskSize.width; u += 7) {
        const Eigen::Vector3d direction =
            direction_from_angles(angles_from_pixel({double(u), double(v)}, kMaskSize));
        const double from_nadir = degrees_from_radians(std::acos(-direction.y()));
        EXPECT_EQ(mask.at<unsigned char>(v, u), from_nadir < angle_deg ? 0 : 255);
      }
    }
  }
  // A cone of half angle a covers (1 - cos a) / 2 of the sphere; rows are one degree.
  for (const double angle_deg : {10.0, 25.0, 60.0}) {
    const double exact = 0.5 * (1.0 - std::cos(radians_from_degrees(angle_deg)));
    EXPECT_NEAR(masked_share(make_mask(kMaskSize, cone(angle_deg))), exact, 1e-4);
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
  EXPECT_EQ(json.at("cone_deg"), 30.0);
  EXPECT_NEAR(json.at("masked_share").get<double>(), 0.067, 0.001);
  EXPECT_TRUE(json.at("frame_masks").is_null());
  EXPECT_TRUE(json.at("picture").is_null() && json.at("automatic").is_null());
  EXPECT_EQ(json.at("station"), "a");
  // Red where it is masked: straight down.
  EXPECT_EQ(json.at("figures")[0].at("row"), "Station a");
  const cv::Mat shown = read_picture(options.out / json.at("figures")[0].at("file"));
  const auto below = shown.at<cv::Vec3b>(shown.rows - 1, 0), above = shown.at<cv::Vec3b>(0, 0);
  EXPECT_GT(below[2], above[2] + 50);
  // Without a cone there is no mask, also none of an earlier run.
  EXPECT_FALSE(write_mask(one_panorama(), {.out = options.out}));
  EXPECT_FALSE(std::filesystem::exists(options.out / "mask.png"));
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
  const auto masks = nlohmann::json::parse(read_file(options.out / "mask.json")).at("frame_masks");
  EXPECT_EQ(masks.at("frames"), 1);
  EXPECT_EQ(masks.at("of_frames"), 1);
  EXPECT_NEAR(masks.at("masked_share").get<double>(), 0.567, 0.001);
  // Also without a mask of all frames, of which there is then no file.
  EXPECT_FALSE(write_mask(set, {.out = options.out}));
  EXPECT_FALSE(std::filesystem::exists(options.out / "mask.png"));
  const auto alone = nlohmann::json::parse(read_file(options.out / "mask.json"));
  EXPECT_NEAR(alone.at("frame_masks").at("masked_share").get<double>(), 0.5, 5e-5);
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

}  // namespace
}  // namespace raywalk::calibrate
