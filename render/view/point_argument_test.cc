#include "render/view/point_argument.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

namespace raywalk::render {
namespace {

using testing::ElementsAre;
using Words = std::vector<std::string>;

TEST(PointTest, NumbersHaveACommaSpacesOrBothBetweenThem) {
  for (const char* text :
       {"-0.1,0.25", "-0.1, 0.25", "-0.1 0.25", " -0.1  ,  0.25 ", "-.1\t+.25"}) {
    EXPECT_THAT(parse_point(text), ElementsAre(-0.1, 0.25)) << text;
  }
  for (const char* text : {"1,2,3", "1 2 3", "1, 2 ,3", " 1  2\t3 ", "1,2 3", "1 ,2 ,3"}) {
    EXPECT_THAT(parse_point(text), ElementsAre(1.0, 2.0, 3.0)) << text;
  }
}

TEST(PointTest, HasTwoOrThreeFiniteNumbersAndNothingElse) {
  for (const char* text : {"", " ", "1", "1,", ",1", "1;2", "x,1", "1,nan", "inf 0", "1e999,0",
                           "1,2,3,4", "1 2 3 4", "0,1 0,2", "1,,2", "1,2,", ",1,2", "1,2,x"}) {
    EXPECT_TRUE(parse_point(text).empty()) << text;
  }
}

class JoinedPointsTest : public testing::Test {
 protected:
  JoinedPointsTest() {
    CLI::App* view = app_.add_subcommand("view");
    add_point_option(view, "--at", &at_, "where");
    view->add_option("--yaw-deg", yaw_deg_);
    add_point_option(view, "--eye", &eye_, "where", PointKind::kPlanOrSpace);
  }
  Words joined(Words words) const { return joined_points(app_, std::move(words)); }

  CLI::App app_{"", "raywalk-test"};
  std::string at_, eye_;
  double yaw_deg_ = 0.0;
};

TEST_F(JoinedPointsTest, WordsOfOnePointBecomeOne) {
  EXPECT_THAT(joined({"view", "--at", "0", "0", "room.lf"}),
              ElementsAre("view", "--at", "0 0", "room.lf"));
  EXPECT_THAT(joined({"view", "--at", "-0.1", "-0.2"}), ElementsAre("view", "--at", "-0.1 -0.2"));
  EXPECT_THAT(joined({"view", "--at", "0,", "0"}), ElementsAre("view", "--at", "0, 0"));
  EXPECT_THAT(joined({"view", "--at", "0", ",0"}), ElementsAre("view", "--at", "0 ,0"));
  EXPECT_THAT(joined({"view", "--at", "0", ",", "0"}), ElementsAre("view", "--at", "0 , 0"));
  EXPECT_THAT(joined({"view", "--at=0", "-1", "x"}), ElementsAre("view", "--at=0 -1", "x"));
}

TEST_F(JoinedPointsTest, APointOfSpaceHasUpToThreeNumbers) {
  EXPECT_THAT(joined({"view", "--eye", "0", "1", "-2", "room.lf"}),
              ElementsAre("view", "--eye", "0 1 -2", "room.lf"));
  EXPECT_THAT(joined({"view", "--eye", "0", ",", "1", ",", "2"}),
              ElementsAre("view", "--eye", "0 , 1 , 2"));
  EXPECT_THAT(joined({"view", "--eye=0,1", "room.lf"}),
              ElementsAre("view", "--eye=0,1", "room.lf"));
}

TEST_F(JoinedPointsTest, OtherWordsStayAsTheyAre) {
  for (const Words& words : {Words{"view", "--at", "0,0", "7"}, Words{"view", "--at=-0.1,0.2", "7"},
                             Words{"view", "--at", "0", "--yaw-deg", "3"}, Words{"view", "--at"},
                             Words{"view", "--at", "0"}, Words{"view", "--yaw-deg", "3", "4"}}) {
    EXPECT_EQ(joined(words), words);
  }
}

}  // namespace
}  // namespace raywalk::render
