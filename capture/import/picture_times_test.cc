#include "capture/import/picture_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "capture/import/test_pictures.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;
using std::chrono::year;

constexpr int kDate = 0x9003;
constexpr int kOffset = 0x9011;
constexpr int kSubSeconds = 0x9291;

const WallTime kNoon = sys_days{year{2026} / 3 / 7} + 12h + 30min + 5s;

class PictureTimesTest : public testing::Test {
 protected:
  std::filesystem::path picture(const std::string& name, const std::map<int, std::string>& tags) {
    const auto file = directory_ / name;
    write_test_picture(file);
    if (!tags.empty()) write_test_exif(file, tags);
    return file;
  }

  TestDirectory directory_;
};

TEST_F(PictureTimesTest, WithoutAnOffsetItIsLocalTimeInWholeSeconds) {
  const auto time = exif_time(picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}}));
  ASSERT_TRUE(time);
  EXPECT_EQ(time->time, kNoon);
  EXPECT_EQ(time->resolution_s, 1.0);
  EXPECT_EQ(time->source, PictureTimeSource::kExifLocal);
}

TEST_F(PictureTimesTest, SubSecondsAreDecimalDigits) {
  const auto tenths =
      exif_time(picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}, {kSubSeconds, "7"}}));
  ASSERT_TRUE(tenths);
  EXPECT_EQ(tenths->time, kNoon + 700ms);
  EXPECT_DOUBLE_EQ(tenths->resolution_s, 0.1);
  const auto thousandths =
      exif_time(picture("b.jpg", {{kDate, "2026:03:07 12:30:05"}, {kSubSeconds, "070"}}));
  ASSERT_TRUE(thousandths);
  EXPECT_EQ(thousandths->time, kNoon + 70ms);
  EXPECT_DOUBLE_EQ(thousandths->resolution_s, 0.001);
}

TEST_F(PictureTimesTest, AnOffsetGivesUtc) {
  const auto east =
      exif_time(picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}, {kOffset, "+02:00"}}));
  ASSERT_TRUE(east);
  EXPECT_EQ(east->time, kNoon - 2h);
  EXPECT_EQ(east->source, PictureTimeSource::kExifUtc);
  const auto west =
      exif_time(picture("b.jpg", {{kDate, "2026:03:07 12:30:05"}, {kOffset, "-05:30"}}));
  ASSERT_TRUE(west);
  EXPECT_EQ(west->time, kNoon + 5h + 30min);
}

TEST_F(PictureTimesTest, AnInvalidOffsetLeavesLocalTime) {
  for (const char* const nonsense : {"", "   :  ", "+2:00", "+99:00", "0200"}) {
    const auto time =
        exif_time(picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}, {kOffset, nonsense}}));
    ASSERT_TRUE(time) << nonsense;
    EXPECT_EQ(time->time, kNoon) << nonsense;
    EXPECT_EQ(time->source, PictureTimeSource::kExifLocal) << nonsense;
  }
}

TEST_F(PictureTimesTest, AnInvalidDateGivesNoTime) {
  for (const char* const nonsense :
       {"0000:00:00 00:00:00", "    :  :     :  :  ", "2026:02:30 12:00:00", "2026:03:07 24:00:00",
        "2026-03-07 12:30:05", "2026:03:07", "", "2026:03:07 12:30:-5"}) {
    EXPECT_FALSE(exif_time(picture("a.jpg", {{kDate, nonsense}}))) << nonsense;
  }
}

TEST_F(PictureTimesTest, ADamagedFileNeverThrows) {
  const auto whole = picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}, {kOffset, "+02:00"}});
  const std::string bytes = read_file(whole);
  const auto damaged = directory_ / "damaged.jpg";
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 300); at += 3) {
    std::ofstream(damaged, std::ios::binary) << bytes.substr(0, at);
    EXPECT_NO_THROW(exif_time(damaged)) << "cut at " << at;
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    std::ofstream(damaged, std::ios::binary) << changed;
    EXPECT_NO_THROW(exif_time(damaged)) << "changed at " << at;
  }
}

TEST_F(PictureTimesTest, WithoutExifItIsTheModificationTime) {
  const std::vector<std::filesystem::path> files{picture("a.jpg", {}), picture("b.jpg", {})};
  const auto times = picture_times(files);
  ASSERT_EQ(times.size(), 2U);
  EXPECT_EQ(times[0].source, PictureTimeSource::kFile);
  EXPECT_EQ(times[0].resolution_s, 2.0);
  const auto written = std::chrono::file_clock::to_sys(std::filesystem::last_write_time(files[0]));
  EXPECT_LT(std::chrono::abs(times[0].time - written), 1ms);
}

TEST_F(PictureTimesTest, APictureWithoutExifAmongOthersIsNamed) {
  std::vector<std::filesystem::path> files{picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}}),
                                           picture("odd.jpg", {})};
  for (int order = 0; order < 2; ++order) {
    EXPECT_THAT([&] { picture_times(files); },
                testing::ThrowsMessage<Error>(testing::HasSubstr("odd.jpg: no Exif time")));
    std::swap(files[0], files[1]);
  }
}

TEST_F(PictureTimesTest, OffsetsFromUtcAreKeptOnlyWhereEveryPictureHasOne) {
  const std::vector<std::filesystem::path> files{
      picture("a.jpg", {{kDate, "2026:03:07 12:30:05"}, {kOffset, "+02:00"}}),
      picture("b.jpg", {{kDate, "2026:03:07 12:30:07"}})};
  const auto times = picture_times(files);
  ASSERT_EQ(times.size(), 2U);
  EXPECT_EQ(times[0].source, PictureTimeSource::kExifLocal);
  EXPECT_EQ(times[1].time - times[0].time, 2s);
  const auto all_utc = picture_times(std::span(files).first(1));
  EXPECT_EQ(all_utc[0].source, PictureTimeSource::kExifUtc);
}

}  // namespace
}  // namespace raywalk::capture
