#include "core/evaluate/metrics/image_pair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/evaluate/metrics/fsim.h"
#include "core/evaluate/metrics/psnr.h"
#include "core/evaluate/metrics/ssim.h"
#include "core/evaluate/metrics/test_images.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(ImagePair, AcceptsEqualSizesFromTheSmallestOn) {
  EXPECT_NO_THROW(
      require_image_pair(flat_image({8, 8}, {0, 0, 0}), flat_image({8, 8}, {1, 1, 1}), 8));
}

TEST(ImagePair, NamesBothSizesWhenTheyDiffer) {
  EXPECT_THAT(
      [] {
        require_image_pair(flat_image({16, 8}, {}), flat_image({16, 9}, {}), 1);
      },
      ThrowsMessage<Error>(AllOf(HasSubstr("16x8"), HasSubstr("16x9"), Not(HasSubstr("\n")))));
}

TEST(ImagePair, RefusesOtherTypesOnEitherSide) {
  const cv::Mat colour = flat_image({16, 8}, {});
  for (const int type : {CV_8UC1, CV_8UC4, CV_16UC3, CV_32FC3}) {
    const cv::Mat other = cv::Mat::zeros(8, 16, type);
    EXPECT_THAT([&] { require_image_pair(colour, other, 1); },
                ThrowsMessage<Error>(HasSubstr(cv::typeToString(type))));
    EXPECT_THROW(require_image_pair(other, colour, 1), Error);
  }
}

TEST(ImagePair, RefusesEmptyImagesAndStacks) {
  const cv::Mat colour = flat_image({16, 8}, {});
  const cv::Mat stack({8, 8, 8}, CV_8UC3);
  EXPECT_THROW(require_image_pair(cv::Mat(), cv::Mat(), 1), Error);
  EXPECT_THROW(require_image_pair(colour, cv::Mat(), 1), Error);
  EXPECT_THROW(require_image_pair(stack, stack, 1), Error);
}

TEST(ImagePair, EveryMetricRefusesUnequalSizes) {
  const cv::Mat a = textured_image({64, 32});
  const cv::Mat b = textured_image({32, 32});
  EXPECT_THROW(mean_squared_error(a, b), Error);
  EXPECT_THROW(psnr_db(a, b), Error);
  EXPECT_THROW(ws_psnr_db(a, b), Error);
  EXPECT_THROW(ssim(a, b), Error);
  EXPECT_THROW(fsim(a, b), Error);
}

TEST(ImagePair, BlockMetricsNeedEightPixelsEachWay) {
  for (const cv::Size size : {cv::Size(7, 8), cv::Size(8, 7)}) {
    const cv::Mat image = textured_image(size);
    EXPECT_THAT([&] { ssim(image, image); }, ThrowsMessage<Error>(HasSubstr("at least 8x8")));
    EXPECT_THAT([&] { fsim(image, image); }, ThrowsMessage<Error>(HasSubstr("at least 8x8")));
  }
}

}  // namespace
}  // namespace raywalk
