#include "calibrate/lens/calibrate_lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/lens/lens_test_camera.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Request {
  TestDirectory directory{};
  CaptureSet set{};
  LensOptions options{};

  Request() {
    options.start = directory / "start.yaml";
    options.out = directory / "out";
    write_lens_file(options.start, plain_camera({640, 320}));
    set.source = "somewhere";
    set.layout = FrameLayout::kDualFisheye;
    set.frame = {640, 320};
    set.lines = {{"x0", LineAxis::kX, 0.0, false, {0}}};
    set.frames.emplace_back();
  }

  std::string complaint() const {
    try {
      calibrate_lens(set, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST(CalibrateLensTest, PanoramasHaveNoLensesToCalibrate) {
  Request request;
  request.set.layout = FrameLayout::kPanorama;
  EXPECT_THAT(request.complaint(), AllOf(HasSubstr("somewhere"), HasSubstr("panoramas already")));
  EXPECT_EQ(request.directory.entries(), 1U);  // nothing written
}

TEST(CalibrateLensTest, StartOfAnotherCameraIsRefused) {
  Request request;
  request.set.frame = {640, 360};
  EXPECT_NE(request.complaint(), "");
  request.set.frame = {640, 320};
  request.set.frames.front().back = "back.jpg";
  EXPECT_THAT(request.complaint(), AllOf(HasSubstr("start.yaml"), HasSubstr("one file")));
  request.options.start = request.directory / "none.yaml";
  EXPECT_THAT(request.complaint(), HasSubstr("none.yaml"));
}

TEST(CalibrateLensTest, InvalidOptionsAreUsageErrors) {
  Request request;
  request.options.pairs = 5;
  EXPECT_THROW(calibrate_lens(request.set, request.options), UsageError);
  request.options.pairs = 24;
  for (const double cone_deg : {-1.0, 90.0, std::nan("")}) {
    request.options.ignore_below_deg = cone_deg;
    EXPECT_THROW(calibrate_lens(request.set, request.options), UsageError) << cone_deg;
  }
}

TEST(CalibrateLensTest, InvalidBoardsAreUsageErrors) {
  Request request;
  request.options.board_pictures = {"board.png"};
  const CharucoBoard right{"DICT_5X5_250", 7, 5, 40.0, 30.0};
  const auto refused = [&](const CharucoBoard& board) {
    request.options.board = board;
    EXPECT_THROW(calibrate_lens(request.set, request.options), UsageError);
    return request.complaint();
  };
  EXPECT_THAT(refused({"DICT_8X8_1", 7, 5, 40.0, 30.0}), HasSubstr("DICT_8X8_1"));
  EXPECT_THAT(refused({"DICT_5X5_250", 2, 5, 40.0, 30.0}), HasSubstr("2 x 5"));
  EXPECT_THAT(refused({"DICT_5X5_250", 7, 5, 40.0, 40.0}), HasSubstr("smaller than its squares"));
  request.options.board_pictures.clear();
  EXPECT_THAT(refused(right), HasSubstr("missing"));
}

}  // namespace
}  // namespace raywalk::calibrate
