#include "core/room/refined_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

TEST(RefinedRecordTest, IsReadAsItWasWritten) {
  const TestDirectory room;
  EXPECT_FALSE(read_refined_record(room.path()));
  write_refined_record(room.path(), {.source = "../hall.lf",
                                     .source_fingerprint = "abc",
                                     .source_stations = 244,
                                     .hold_out = 5,
                                     .sharpening = {0.75, 1.5}});
  const auto record = read_refined_record(room.path());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->source, "../hall.lf");
  EXPECT_EQ(record->source_fingerprint, "abc");
  EXPECT_EQ(record->source_stations, 244);
  EXPECT_EQ(record->hold_out, 5);
  EXPECT_EQ(record->sharpening, (std::array<double, 2>{0.75, 1.5}));
  // The captured room may be elsewhere by now.
  EXPECT_THAT(refined_text(room.path()), HasSubstr("whether that has changed is unknown"));
}

TEST(RefinedRecordTest, DamageIsNamed) {
  const TestDirectory room;
  write_refined_record(room.path(), {.source = "a", .source_stations = 1});
  const std::string text = read_file(room / "refined.json");
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string other = text;
    other.replace(other.find(from), from.size(), to);
    return other;
  };
  for (const std::string& damaged :
       {std::string(), text.substr(0, 20), replaced("raywalk-refined", "raywalk-room"),
        replaced("\"format_version\": 1", "\"format_version\": 99"),
        replaced("\"source_stations\": 1", "\"source_stations\": 0")}) {
    write_file_atomically(room / "refined.json", damaged);
    try {
      read_refined_record(room.path());
      ADD_FAILURE() << damaged;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("refined.json"));
    }
  }
}

}  // namespace
}  // namespace raywalk
