#include "core/http/byte_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace raywalk {
namespace {

using testing::ElementsAre;

std::vector<ByteRange> parts_of(std::string_view value, std::uint64_t size = 1000) {
  const RequestedRanges ranges = parse_byte_ranges(value, size);
  EXPECT_EQ(ranges.answer, RangeAnswer::kParts) << value;
  return ranges.parts;
}

RangeAnswer answer_to(std::string_view value, std::uint64_t size = 1000) {
  const RequestedRanges ranges = parse_byte_ranges(value, size);
  EXPECT_EQ(ranges.parts.empty(), ranges.answer != RangeAnswer::kParts) << value;
  return ranges.answer;
}

TEST(ByteRanges, AreThoseOfTheStandardsExamples) {
  EXPECT_THAT(parts_of("bytes=0-499", 10000), ElementsAre(ByteRange{0, 499}));
  EXPECT_THAT(parts_of("bytes=500-999", 10000), ElementsAre(ByteRange{500, 999}));
  EXPECT_THAT(parts_of("bytes=-500", 10000), ElementsAre(ByteRange{9500, 9999}));
  EXPECT_THAT(parts_of("bytes=9500-", 10000), ElementsAre(ByteRange{9500, 9999}));
  EXPECT_THAT(parts_of("bytes=0-0,-1", 10000), ElementsAre(ByteRange{0, 0}, ByteRange{9999, 9999}));
  EXPECT_THAT(parts_of("bytes= 0-999, 4500-5499, -1000", 10000),
              ElementsAre(ByteRange{0, 999}, ByteRange{4500, 5499}, ByteRange{9000, 9999}));
}

TEST(ByteRanges, EndWithTheFile) {
  EXPECT_THAT(parts_of("bytes=990-2000"), ElementsAre(ByteRange{990, 999}));
  EXPECT_THAT(parts_of("bytes=-2000"), ElementsAre(ByteRange{0, 999}));
  EXPECT_THAT(parts_of("bytes=0-99999999999999999999999999"), ElementsAre(ByteRange{0, 999}));
  EXPECT_THAT(parts_of("bytes=-99999999999999999999999999"), ElementsAre(ByteRange{0, 999}));
  EXPECT_THAT(parts_of("bytes=999-18446744073709551615"), ElementsAre(ByteRange{999, 999}));
}

TEST(ByteRanges, CannotBeSatisfiedBehindTheEnd) {
  for (const char* value : {"bytes=1000-", "bytes=1000-1001", "bytes=-0",
                            "bytes=18446744073709551616-", "bytes=5000-,-0"}) {
    EXPECT_EQ(answer_to(value), RangeAnswer::kUnsatisfiable) << value;
  }
  for (const char* value : {"bytes=0-", "bytes=0-0", "bytes=-5"}) {
    EXPECT_EQ(answer_to(value, 0), RangeAnswer::kUnsatisfiable) << value;
  }
  EXPECT_THAT(parts_of("bytes=5000-,0-1"), ElementsAre(ByteRange{0, 1}));
}

TEST(ByteRanges, AreIgnoredWhereTheyAreNone) {
  for (const char* value :
       {"", "bytes", "bytes=", "bytes=,", "bytes=-", "bytes=a-b", "bytes=1-0", "bytes=0-1,x",
        "bytes=0x0-5", "bytes=+1-5", "bytes=1--5", "bytes=--5", "bytes=1 - 5", "bytes 0-5",
        "items=0-5", "0-5", "bytes =0-5", "bytes=0-5;6-7", "bytes=2-1,0-0"}) {
    EXPECT_EQ(answer_to(value), RangeAnswer::kWhole) << value;
  }
  EXPECT_THAT(parts_of("BYTES=0-5"), ElementsAre(ByteRange{0, 5}));
  EXPECT_THAT(parts_of("bytes=,0-5,,"), ElementsAre(ByteRange{0, 5}));
}

TEST(ByteRanges, AreMergedWhereTheyOverlap) {
  EXPECT_THAT(parts_of("bytes=0-5,3-9"), ElementsAre(ByteRange{0, 9}));
  EXPECT_THAT(parts_of("bytes=5-9,0-4"), ElementsAre(ByteRange{0, 9}));
  EXPECT_THAT(parts_of("bytes=0-999,0-999,0-999,-1000"), ElementsAre(ByteRange{0, 999}));
  EXPECT_THAT(parts_of("bytes=0-999,100-200"), ElementsAre(ByteRange{0, 999}));
  // Disjoint ones come in the order they were asked for.
  EXPECT_THAT(parts_of("bytes=20-29,0-4"), ElementsAre(ByteRange{20, 29}, ByteRange{0, 4}));
}

TEST(ByteRanges, AreIgnoredWhereTheyAreMany) {
  std::string value = "bytes=0-0";
  for (std::size_t i = 1; i < kMostByteRanges; ++i)
    value += "," + std::to_string(2 * i) + "-" + std::to_string(2 * i);
  EXPECT_EQ(parts_of(value).size(), kMostByteRanges);
  EXPECT_EQ(answer_to(value + ",900-901"), RangeAnswer::kWhole);
}

TEST(ByteRanges, StateTheirPlace) {
  EXPECT_EQ(content_range({42, 1233}, 1234), "bytes 42-1233/1234");
}

}  // namespace
}  // namespace raywalk
