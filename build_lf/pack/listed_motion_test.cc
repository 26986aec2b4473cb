#include "build_lf/pack/listed_motion.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <opencv2/core.hpp>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// What is said of the photographed room with positions changed.
class ListedMotionTest : public ::testing::Test {
 protected:
  std::string fault(const std::function<void(ListedFrame*)>& change) const {
    std::vector<ListedFrame> rows;
    for (const Frame& frame : read_frame_list(fs::path(RAYWALK_TEST_ROOM) / "poses.csv")) {
      rows.push_back({.file = frame.path.string(), .position_m = frame.position_m});
      change(&rows.back());
    }
    write_file_atomically(directory_ / "poses.csv", frame_list_text(rows));
    PackOptions options;
    options.frames = directory_ / "poses.csv";
    options.out = directory_ / "room.lf";
    const PackPlan plan = plan_pack(options);
    return error_of([&] { require_listed_motion(plan, "poses.csv"); });
  }

  TestDirectory directory_;
};

TEST_F(ListedMotionTest, RightListsPassAndWrongAxesAreNamed) {
  EXPECT_EQ(fault([](ListedFrame*) {}), "no error");
  EXPECT_THAT(fault([](ListedFrame* row) { row->position_m.z() *= -1; }),
              AllOf(HasSubstr("what is listed along z moves along -z"),
                    HasSubstr("z grows the other way in the list")));
  EXPECT_THAT(fault([](ListedFrame* row) { row->position_m.x() *= -1; }), HasSubstr("mirrored"));
  EXPECT_THAT(fault([](ListedFrame* row) { row->position_m *= -1; }), HasSubstr("backwards"));
  EXPECT_THAT(fault([](ListedFrame* row) {
                row->position_m = {row->position_m.z(), 0.0, -row->position_m.x()};
              }),
              HasSubstr("turned by 90 degrees"));
  EXPECT_THAT(fault([](ListedFrame* row) { std::swap(row->position_m.x(), row->position_m.z()); }),
              HasSubstr("x and z are exchanged"));
}

TEST_F(ListedMotionTest, ALineInReverseOrderIsNamed) {
  EXPECT_THAT(fault([](ListedFrame* row) {
                if (row->file.find("back_") != std::string::npos) row->position_m.x() *= -1;
              }),
              AllOf(HasSubstr("line x0"), HasSubstr("back_"), HasSubstr("reverse order")));
}

// Turned pictures with their attitudes are as good as upright ones.
TEST_F(ListedMotionTest, AttitudesAreHonoured) {
  const auto turned = [](double yaw_rad) {
    return [=](ListedFrame* row) { row->attitude = {.yaw_rad = yaw_rad}; };
  };
  EXPECT_EQ(fault(turned(0.0)), "no error");
  EXPECT_THAT(fault(turned(kPi)), HasSubstr("backwards"));
}

TEST(CostsOfTravel, EqualAndUnrelatedPicturesSayNothing) {
  cv::Mat noise(128, 256, CV_8UC3), other = noise.clone();
  cv::randu(noise, 0, 255);
  cv::randu(other, 0, 255);
  for (const double cost : costs_of_travel(noise, noise)) EXPECT_EQ(cost, 1.0);
  const cv::Mat plain(128, 256, CV_8UC3, cv::Scalar::all(40));
  for (const double cost : costs_of_travel(plain, plain)) EXPECT_EQ(cost, 1.0);
  const DirectionCosts costs = costs_of_travel(noise, other);
  const auto [least, most] = std::ranges::minmax(costs);
  EXPECT_GT(least, 0.8 * most);  // none is clearly better than another
}

}  // namespace
}  // namespace raywalk::build_lf
