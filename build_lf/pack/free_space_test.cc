#include "build_lf/pack/free_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;

std::string error_for(const NeededSpace& space, std::optional<std::uint64_t> free) {
  return error_of([&] { require_space("room.lf.partial", space, free); });
}

TEST(RequireSpace, NothingIsSaidWhereItFitsOrIsUnknown) {
  EXPECT_EQ(error_for({.needed = 1000}, 1000), "no error");
  EXPECT_EQ(error_for({.needed = 1000}, std::nullopt), "no error");
}

TEST(RequireSpace, SizesHaveAFittingUnitAndDiffer) {
  EXPECT_THAT(error_for({.needed = 39'000'000}, 31'000'000),
              HasSubstr("room.lf.partial: the room needs 39 MB, 31 MB are free"));
  EXPECT_THAT(error_for({.needed = 70'000'001}, 70'000'000),
              HasSubstr("needs 71 MB, 70 MB are free"));
  EXPECT_THAT(error_for({.needed = 12'400'000'000'000}, 900), HasSubstr("13 TB, 0 TB"));
  EXPECT_THAT(error_for({.needed = 9'999}, 0), HasSubstr("9999 bytes, 0 bytes"));
}

TEST(RequireSpace, WhatIsThereIsSaid) {
  EXPECT_THAT(error_for({.needed = 39'000'000, .there = 31'400'000}, 20'000'000),
              HasSubstr("needs 39 MB besides the 31 MB that are there, 20 MB are free"));
}

}  // namespace
}  // namespace raywalk::build_lf
