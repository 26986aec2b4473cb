#include "simulator/rig/render_ahead.h"

#include <gtest/gtest.h>

#include <atomic>

#include "core/base/error.h"

namespace raywalk::simulator {
namespace {

CameraPose at_mm(double x_mm, double yaw_rad = 0.0) {
  CameraPose pose;
  pose.position_m.x() = 1e-3 * x_mm;
  pose.attitude.yaw_rad = yaw_rad;
  return pose;
}

// Renders a picture of one pixel: the camera's x in millimetres.
class RenderAheadTest : public ::testing::Test {
 protected:
  RenderAhead ahead(double tolerance_mm) {
    return {[this](const CameraPose& pose) {
              ++rendered_;
              if (pose.position_m.x() < 0.0) throw Error("outside the room");
              return cv::Mat(1, 1, CV_64FC1, cv::Scalar(1e3 * pose.position_m.x()));
            },
            tolerance_mm};
  }
  static double x_mm(const SceneView& view) { return view.image.at<double>(0, 0); }

  std::atomic<int> rendered_{0};
};

TEST_F(RenderAheadTest, TheLastExpectedPoseIsRenderedOnceAndIsWhatTheViewIsFrom) {
  RenderAhead ahead = this->ahead(0.1);
  ahead.expect(at_mm(20.0));
  for (const double x : {20.0, 20.09, 19.91}) {
    const SceneView view = ahead.view(at_mm(x));
    EXPECT_DOUBLE_EQ(x_mm(view), 20.0);
    EXPECT_EQ(view.pose.position_m.x(), at_mm(20.0).position_m.x());
  }
  EXPECT_EQ(rendered_, 1);
  for (int x = 1; x <= 50; ++x) ahead.expect(at_mm(x));
  EXPECT_DOUBLE_EQ(x_mm(ahead.view(at_mm(50.05))), 50.0);
  ahead.expect(at_mm(-1.0));
  EXPECT_THROW(ahead.view(at_mm(-1.0)), Error) << "what cannot be rendered fails when it is seen";
}

TEST_F(RenderAheadTest, AnotherPoseIsRenderedWhenItIsSeen) {
  RenderAhead ahead = this->ahead(0.1);
  EXPECT_DOUBLE_EQ(x_mm(ahead.view(at_mm(5.0))), 5.0);
  ahead.expect(at_mm(10.0));
  ahead.expect(at_mm(20.0));
  for (const CameraPose& pose : {at_mm(20.11), at_mm(20.0, 1e-4), at_mm(10.0)}) {
    const SceneView view = ahead.view(pose);
    EXPECT_DOUBLE_EQ(x_mm(view), 1e3 * pose.position_m.x());
    EXPECT_EQ(view.pose.attitude.yaw_rad, pose.attitude.yaw_rad);
  }
}

}  // namespace
}  // namespace raywalk::simulator
