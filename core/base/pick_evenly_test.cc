#include "core/base/pick_evenly.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace raywalk {
namespace {

TEST(PickEvenly, TakesAllIfFewOtherwiseEvenly) {
  // The middles of equal parts.
  EXPECT_THAT(pick_evenly(100, 4), ::testing::ElementsAre(12, 37, 62, 87));
  EXPECT_THAT(pick_evenly(100, 1), ::testing::ElementsAre(50));
  EXPECT_THAT(pick_evenly(3, 3), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(3, 12), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(pick_evenly(0, 12), ::testing::IsEmpty());
}

}  // namespace
}  // namespace raywalk
