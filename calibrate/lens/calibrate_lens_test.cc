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

}  // namespace
}  // namespace raywalk::calibrate
