#include "core/evaluate/trade/trade_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class CapturedViewsTest : public ::testing::Test {
 protected:
  Room room(const std::string& name, const SyntheticRoomSpec& spec) const {
    write_synthetic_room(spec, directory_ / name);
    return Room::open(directory_ / name);
  }
  template <typename Work>
  static std::string error_of(const Work& work) {
    try {
      work();
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }

  TestDirectory directory_;
};

TEST_F(CapturedViewsTest, FewTruthsAreSpreadOverTheDistanceFromTheLine) {
  const Room main = room("room.lf", {.width = 64});
  std::vector<TruthView> truths;
  for (int i = 0; i < 9; ++i) {
    const std::string name = "view" + std::to_string(i);
    write_image(directory_ / (name + ".png"), cv::Mat(16, 32, CV_8UC3, cv::Scalar::all(i)));
    truths.push_back({.name = name,
                      .file = directory_ / (name + ".png"),
                      .width = 32,
                      .line_distance_m = 0.1 * i});
  }
  const std::vector<TradeView> views = captured_views(main, truths, 3);
  ASSERT_EQ(views.size(), 3U);
  EXPECT_EQ(views[0].name, "view0");
  EXPECT_EQ(views[1].name, "view4");
  EXPECT_EQ(views[2].name, "view8");
  EXPECT_EQ(views[1].truth.at<cv::Vec3b>(3, 3)[0], 4);
  EXPECT_EQ(captured_views(main, truths, 20).size(), 9U);
}

TEST_F(CapturedViewsTest, RefusesTruthsOfDifferentWidths) {
  const Room main = room("room.lf", {.width = 64});
  const std::vector<TruthView> truths{{.name = "a", .file = "a.png", .width = 32},
                                      {.name = "b", .file = "b.png", .width = 64}};
  EXPECT_THAT(error_of([&] { captured_views(main, truths, 2); }),
              AllOf(HasSubstr("b.png is 64"), HasSubstr("one width")));
}

}  // namespace
}  // namespace raywalk
