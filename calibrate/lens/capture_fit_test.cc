#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/lens_test_camera.h"
#include "core/base/test_error.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "simulator/room/sensor.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr PanoramaSize kCapturedPicture{560, 280};

// Two lines, one along each axis, each off the plan, of a furnished room, taken once for all tests.
struct Capture {
  TestDirectory directory{};
  CaptureSet set{};
};

void add_station(const capture::VirtualRoom& room, const DualFisheyeLayout& lenses, int line,
                 int number, Capture* capture) {
  CaptureFrame frame;
  frame.name = (line == 0 ? "x0_" : "z0_") + std::to_string(number);
  frame.line = line;
  frame.file = capture->directory / (frame.name + ".png");
  const double along_m = -0.6 + 0.3 * number, across_m = line == 0 ? -0.5 : 0.5;
  frame.nominal_m = line == 0 ? Vector3d(along_m, 0, across_m) : Vector3d(across_m, 0, along_m);
  const double sign = line == 0 ? 1.0 : -1.0;
  const Attitude placed{radians_from_degrees(sign * 1.1), radians_from_degrees(-0.4 * sign),
                        radians_from_degrees(0.7 + 0.1 * number)};
  capture::CameraPose pose{frame.nominal_m + Vector3d(0.012, -0.006 * sign, 0.009), placed};
  pose.position_m[line == 0 ? 2 : 0] += sign * 0.01 * along_m;  // the rail itself is turned
  const cv::Mat clean = room.render(capture::DualFisheyeRays(lenses, kCapturedPicture), pose);
  write_image(frame.file, capture::apply_sensor(clean, {1.0, 0.01, 0.0}, 1.0,
                                                static_cast<std::uint64_t>(10 * line + number)));
  capture->set.lines[static_cast<std::size_t>(line)].frames.push_back(
      static_cast<int>(capture->set.frames.size()));
  capture->set.frames.push_back(std::move(frame));
}

const Capture& capture() {
  static const Capture* const taken = [] {
    auto* made = new Capture;
    made->set.layout = FrameLayout::kDualFisheye;
    made->set.frame = kCapturedPicture;
    made->set.lines = {{"x0", LineAxis::kX, -0.5, false, {}}, {"z0", LineAxis::kZ, 0.5, false, {}}};
    const capture::VirtualRoom room((capture::VirtualRoomSettings()));
    for (int line = 0; line < 2; ++line) {
      for (int i = 0; i < 5; ++i)
        add_station(room, true_camera(kCapturedPicture).layout, line, i, made);
    }
    return made;
  }();
  return *taken;
}

TEST(CaptureFitTest, RecoversLensesFromTheFramesOfACapture) {
  const DualFisheyeCamera start = plain_camera(kCapturedPicture),
                          truth = true_camera(kCapturedPicture);
  ASSERT_GT(imaging_difference_px(start.layout, truth.layout), 1.5);
  const LensFit fit = fit_to_capture(capture().set, start, {.pairs = 10});
  EXPECT_LT(imaging_difference_px(fit.camera.layout, truth.layout), 0.3);
  EXPECT_LT(fit.residual_px, 0.4);
  EXPECT_LT(fit.sigma.worst_px(), 0.3);
  EXPECT_GT(fit.overlap_points, 20);
  EXPECT_TRUE(fit.trustworthy());
  // The field of view is seen in the pictures, the start has 95 degrees.
  EXPECT_NEAR(degrees_from_radians(fit.camera.layout.front.largest_angle_rad), 97.0, 0.5);
  EXPECT_NEAR(degrees_from_radians(fit.camera.layout.back.largest_angle_rad), 97.0, 0.5);
  EXPECT_EQ(fit.pictures, 10);
  EXPECT_EQ(static_cast<int>(fit.residuals.size()), fit.observations);
}

// The same capture with every picture changed.
template <typename Change>
CaptureSet changed_pictures(const TestDirectory& directory, const Change& change) {
  CaptureSet set = capture().set;
  for (CaptureFrame& frame : set.frames) {
    const cv::Mat picture = change(read_picture(frame.file));
    frame.file = directory / (frame.name + ".png");
    write_image(frame.file, picture);
  }
  return set;
}

// Pictures that contradict the plan, or show nothing to go by.
TEST(CaptureFitTest, OtherPicturesAreRefusedWithAdvice) {
  const auto complaint = [](const CaptureSet& set, const DualFisheyeCamera& start) {
    return error_of([&] { fit_to_capture(set, start, {.pairs = 10}); });
  };
  const TestDirectory directory;
  const DualFisheyeCamera start = plain_camera(kCapturedPicture);
  const CaptureSet mirrored = changed_pictures(directory, [](const cv::Mat& picture) {
    // Each half by itself, as a camera would that flips what its sensors see.
    cv::Mat flipped(picture.size(), picture.type());
    for (const int half : {0, 1}) {
      const cv::Rect area(half * picture.cols / 2, 0, picture.cols / 2, picture.rows);
      cv::Mat target = flipped(area);
      cv::flip(picture(area), target, 1);
    }
    return flipped;
  });
  EXPECT_THAT(complaint(mirrored, start), HasSubstr("mirrored"));
  DualFisheyeCamera swapped = start;
  std::swap(swapped.layout.front, swapped.layout.back);
  EXPECT_THAT(complaint(capture().set, swapped), HasSubstr("swapped"));
  const CaptureSet plain = changed_pictures(directory, [](const cv::Mat& picture) {
    return cv::Mat(picture.size(), picture.type(), cv::Scalar(90, 100, 110));
  });
  EXPECT_THAT(complaint(plain, start),
              ::testing::AllOf(HasSubstr("only 0 features"), HasSubstr("more texture")));
}

}  // namespace
}  // namespace raywalk::calibrate
