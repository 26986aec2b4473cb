#include "core/view/picture_fill.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

namespace raywalk {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 48;
const cv::Vec3b kWall(90, 120, 150);
const cv::Vec3b kUnknown(0, 255, 0);

// A panorama with unknown places, which are green.
struct Picture {
  cv::Mat image = cv::Mat(kHeight, kWidth, CV_8UC3, kWall);
  std::vector<UnknownRows> rows = std::vector<UnknownRows>(kWidth);

  void forget(const cv::Rect& where) {
    for (int x = where.x; x < where.x + where.width; ++x) {
      const int column = (x + kWidth) % kWidth;
      rows[static_cast<size_t>(column)].push_back({where.y, where.y + where.height});
      image.col(column).rowRange(where.y, where.y + where.height) = kUnknown;
    }
  }
  UnknownPixels unknown(Seam seam = Seam::kJoined) const {
    return {rows, seam, {0, kHeight}, kHeight};
  }
  // The largest difference from a colour.
  double off(const cv::Vec3b& color) const {
    return cv::norm(image, cv::Mat(image.size(), CV_8UC3, color), cv::NORM_INF);
  }
};

TEST(PictureFill, PlacesAnywhereTakeTheColourAround) {
  for (const cv::Rect& where : {cv::Rect(30, 10, 20, 15), cv::Rect(-8, 20, 20, 9),
                                cv::Rect(0, 40, kWidth, 8), cv::Rect(5, 0, 2, kHeight),
                                cv::Rect(kWidth - 1, 7, 1, 1), cv::Rect(10, 3, kWidth - 4, 40)}) {
    Picture picture;
    picture.forget(where);
    fill_picture(picture.unknown(), &picture.image);
    EXPECT_EQ(picture.off(kWall), 0.0) << where;
  }
}

TEST(PictureFill, PlacesBesideEachOtherDoNotShowInEachOther) {
  Picture picture;
  for (int i = 0; i < 12; ++i) picture.forget({8 * i, 6 + 2 * i, 5, 5});
  picture.forget({40, 20, 30, 20});  // overlaps some of them
  fill_picture(picture.unknown(), &picture.image);
  EXPECT_EQ(picture.off(kWall), 0.0);
}

TEST(PictureFill, KnownPixelsStay) {
  Picture picture;
  cv::randu(picture.image, 0, 255);
  const cv::Mat before = picture.image.clone();
  picture.forget({30, 10, 20, 15});
  fill_picture(picture.unknown(), &picture.image);
  cv::Mat known(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  known(cv::Rect(30, 10, 20, 15)) = 0;
  EXPECT_EQ(cv::norm(before, picture.image, cv::NORM_INF, known), 0.0);
}

TEST(PictureFill, APictureOfWhichNothingIsKnownStays) {
  Picture picture;
  picture.forget({0, 0, kWidth, kHeight});
  fill_picture(picture.unknown(), &picture.image);
  EXPECT_EQ(picture.off(kUnknown), 0.0);
}

// A part of which only some rows were rendered: the others hold anything.
TEST(PictureFill, RowsThatWereNotRenderedAreNotLookedAt) {
  Picture picture;
  picture.forget({30, 10, 20, 15});
  picture.image.rowRange(0, 5) = kUnknown;
  UnknownPixels unknown = picture.unknown(Seam::kOpen);
  unknown.rows = {5, kHeight};
  fill_picture(unknown, &picture.image);
  EXPECT_EQ(cv::norm(picture.image.rowRange(5, kHeight),
                     cv::Mat(kHeight - 5, kWidth, CV_8UC3, kWall), cv::NORM_INF),
            0.0);
}

TEST(PictureFill, OnlyLargePlacesThatThePartCutsOffAreUnknownAtItsBorder) {
  const auto is_cut_off = [](const cv::Rect& where, Seam seam, RowRun rows) {
    Picture picture;
    picture.forget(where);
    UnknownPixels unknown = picture.unknown(seam);
    unknown.rows = rows;
    return is_unknown_at_border(unknown, 6);
  };
  const RowRun all{0, kHeight};
  EXPECT_FALSE(is_cut_off({30, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({0, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({kWidth - 20, 10, 20, 15}, Seam::kOpen, all));
  EXPECT_FALSE(is_cut_off({0, 10, 20, 15}, Seam::kJoined, all));
  EXPECT_FALSE(is_cut_off({0, 10, 3, 3}, Seam::kOpen, all));
  // The nadir is not a border.
  EXPECT_FALSE(is_cut_off({30, 30, 20, kHeight - 30}, Seam::kOpen, all));
  EXPECT_TRUE(is_cut_off({30, 10, 20, 15}, Seam::kOpen, {0, 20}));
  EXPECT_TRUE(is_cut_off({30, 10, 20, 15}, Seam::kOpen, {15, kHeight}));
}

}  // namespace
}  // namespace raywalk
