#include "core/base/median.h"

#include <gtest/gtest.h>

namespace raywalk {
namespace {

TEST(Median, IsTheMiddleOfAnOddNumber) { EXPECT_EQ(median({5.0, -1.0, 3.0}), 3.0); }

TEST(Median, IsTheUpperMiddleOfAnEvenNumber) { EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 3.0); }

TEST(Median, OfOneValueIsThatValue) { EXPECT_EQ(median({7.5}), 7.5); }

TEST(Median, IsNotMovedByAnOutlier) { EXPECT_EQ(median({1.0, 2.0, 1e300}), 2.0); }

}  // namespace
}  // namespace raywalk
