#include "core/files/turned_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_log.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(TurnedPictures, UprightOnesAreNotMentioned) {
  const CapturedLog log;
  TurnedPictures turned;
  turned.add("a.jpg", 1);
  turned.warn();
  EXPECT_THAT(log.text(), IsEmpty());
}

TEST(TurnedPictures, OneWarningNamesTheFirstAndCountsTheOthers) {
  const CapturedLog log;
  TurnedPictures turned;
  turned.add("a.jpg", 1);
  turned.add("b.jpg", 6);
  for (int i = 0; i < 3; ++i) turned.add("c.jpg", 3);
  turned.warn();
  EXPECT_THAT(log.text(),
              AllOf(HasSubstr("b.jpg"), HasSubstr("orientation 6"), HasSubstr("90 degrees"),
                    HasSubstr("3 more"), HasSubstr("pixels are used as they are stored")));
}

}  // namespace
}  // namespace raywalk
