// What is filled in a picture from what surrounds it.
#include "core/view/picture_fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/view/unknown_pixels.h"

namespace raywalk {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 48;
const cv::Vec3b kWall(90, 120, 150);
const cv::Vec3b kUnknown(0, 255, 0);

// A picture whose values are not known in a rectangle, and absurd there.
struct HoledPicture {
  cv::Mat1f values = cv::Mat1f(kHeight, kWidth), truth;
  cv::Mat1b unknown = cv::Mat1b::zeros(kHeight, kWidth);

  template <typename ValueAt>
  HoledPicture(const ValueAt& value_at, const cv::Rect& hole) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) values(y, x) = static_cast<float>(value_at(x, y));
    }
    truth = values.clone();
    values(hole) = 1e6f;
    unknown(hole) = 255;
  }
  bool fill(Seam seam) { return fill_unknown(unknown, seam, {0, kHeight}, &values); }
  double largest_error() const { return cv::norm(values, truth, cv::NORM_INF); }
};

TEST(UnknownPixels, AConstantStaysAndARampIsContinued) {
  for (const Seam seam : {Seam::kOpen, Seam::kJoined}) {
    HoledPicture constant([](int, int) { return 7.5; }, {20, 5, 40, 43});
    EXPECT_TRUE(constant.fill(seam));
    EXPECT_LT(constant.largest_error(), 1e-4);
  }
  HoledPicture ramp([](int x, int y) { return 2.0 * x + y; }, {30, 12, 24, 20});
  EXPECT_TRUE(ramp.fill(Seam::kOpen));
  EXPECT_LT(ramp.largest_error(), 4.0);  // of 66 across the hole
}

TEST(UnknownPixels, OneKnownPixelFillsAllAndNoneNothing) {
  HoledPicture picture([](int, int) { return 3.0; }, {0, 0, kWidth, kHeight});
  EXPECT_FALSE(picture.fill(Seam::kJoined));
  EXPECT_EQ(picture.values(5, 7), 1e6f);
  picture.values(31, 77) = 3.0f;
  picture.unknown(31, 77) = 0;
  EXPECT_TRUE(picture.fill(Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-5);
}

// Left of the hole is 0, right of it 100: with the seam joined, a hole across it goes smoothly from
// one to the other; else its border does not reach the other side.
TEST(UnknownPixels, AHoleAcrossTheSeamIsFilledFromBothOfItsSides) {
  HoledPicture picture([](int x, int) { return x < kWidth / 2 ? 0.0 : 100.0; },
                       {0, 0, 12, kHeight});
  const cv::Mat1f before = picture.values.clone();
  EXPECT_TRUE(picture.fill(Seam::kOpen));
  EXPECT_LT(picture.largest_error(), 1e-3);
  before.copyTo(picture.values);
  picture.unknown.colRange(kWidth - 12, kWidth) = 255;
  EXPECT_TRUE(picture.fill(Seam::kJoined));
  const auto at = [&](int x) { return picture.values(kHeight / 2, (x + kWidth) % kWidth); };
  for (int x = -12; x < 12; ++x) EXPECT_LT(std::fabs(at(x) - at(x - 1)), 100.0 / 8.0) << x;
  EXPECT_NEAR(0.5 * (at(-1) + at(0)), 50.0, 3.0);
}

// All columns of a panorama meet at a pole: what is filled there must not depend on the column.
TEST(UnknownPixels, APoleHasOneValue) {
  HoledPicture picture([](int x, int) { return x % 24 < 12 ? 0.0 : 100.0; },
                       {0, kHeight - 16, kWidth, 16});
  EXPECT_TRUE(picture.fill(Seam::kJoined));
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(picture.values.row(kHeight - 1), &least, &most);
  EXPECT_NEAR(least, 50.0, 5.0);
  EXPECT_NEAR(most, 50.0, 5.0);
}

// A panorama with places that were not read, which are green.
struct Picture {
  cv::Mat image = cv::Mat(kHeight, kWidth, CV_8UC3, kWall);
  cv::Mat1b unread = cv::Mat1b::zeros(kHeight, kWidth);

  void forget(const cv::Rect& where) {
    for (int x = where.x; x < where.x + where.width; ++x) {
      const cv::Rect column((x + kWidth) % kWidth, where.y, 1, where.height);
      unread(column) = 255;
      image(column) = kUnknown;
    }
  }
  void fill(Seam seam = Seam::kJoined) { fill_picture(unread, seam, {0, kHeight}, &image); }
  // The largest difference from a colour.
  double off(const cv::Vec3b& color) const {
    return cv::norm(image, cv::Mat(image.size(), CV_8UC3, color), cv::NORM_INF);
  }
};

TEST(PictureFill, PlacesAnywhereTakeTheColourAround) {
  const cv::Rect all(0, 0, kWidth, kHeight);
  for (const cv::Rect& where :
       {cv::Rect(30, 10, 20, 15), cv::Rect(-8, 20, 20, 9), cv::Rect(0, 40, kWidth, 8),
        cv::Rect(5, 0, 2, kHeight), cv::Rect(kWidth - 1, 7, 1, 1), all}) {
    Picture picture;
    picture.forget(where);
    picture.fill();
    EXPECT_EQ(picture.off(where == all ? kUnknown : kWall), 0.0) << where;
  }
}

TEST(PictureFill, PlacesBesideEachOtherDoNotShowInEachOther) {
  Picture picture;
  for (int i = 0; i < 12; ++i) picture.forget({8 * i, 6 + 2 * i, 5, 5});
  picture.forget({40, 20, 30, 20});  // overlaps some of them
  picture.fill();
  EXPECT_EQ(picture.off(kWall), 0.0);
}

TEST(PictureFill, KnownPixelsStay) {
  for (const Seam seam : {Seam::kOpen, Seam::kJoined}) {
    Picture picture;
    cv::randu(picture.image, 0, 255);
    const cv::Mat before = picture.image.clone();
    picture.forget({30, 10, 20, 15});
    picture.forget({-4, 30, 8, 8});
    picture.fill(seam);
    EXPECT_EQ(cv::norm(before, picture.image, cv::NORM_INF, picture.unread == 0), 0.0);
  }
}

TEST(PictureFill, OnlyLargePlacesThatThePartCutsOffAreUnreadAtItsBorder) {
  const auto is_cut_off = [](const cv::Rect& where, Seam seam, ShownRows rows) {
    Picture picture;
    picture.forget(where);
    return is_unread_at_border(picture.unread, seam, rows, 6);
  };
  const ShownRows all{0, kHeight};
  EXPECT_FALSE(is_cut_off({30, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({0, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({kWidth - 20, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_FALSE(is_cut_off({0, 10, 20, 15}, Seam::kJoined, all));
  EXPECT_FALSE(is_cut_off({0, 10, 3, 3}, Seam::kOpen, all));
  // The nadir is not a border.
  EXPECT_FALSE(is_cut_off({30, 30, 20, kHeight - 30}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({30, 30, 20, kHeight - 30}, Seam::kOpen, {0, 2 * kHeight}));
  EXPECT_TRUE(is_cut_off({30, 0, 20, 15}, Seam::kOpen, {kHeight, 2 * kHeight}));
}

}  // namespace
}  // namespace raywalk
