#include "capture/import/card_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <optional>

#include "capture/import/test_pictures.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

using Tags = std::map<int, std::string>;
constexpr int kDate = 0x9003;
constexpr int kOffset = 0x9011;
constexpr int kSubSeconds = 0x9291;

const WallTime kNoon = std::chrono::sys_days{std::chrono::year{2026} / 3 / 7} + 12h + 30min + 5s;
const std::string kNoonText = "2026:03:07 12:30:05";

class CardPicturesTest : public testing::Test {
 protected:
  fs::path picture(const std::string& name, const Tags& tags) {
    const fs::path file = card_ / name;
    fs::create_directories(file.parent_path());
    write_test_picture(file);
    if (!tags.empty()) write_test_exif(file, tags);
    return file;
  }
  // A picture taken `second` seconds after noon.
  fs::path picture(const std::string& name, int second) {
    return picture(name, {{kDate, fmt::format("2026:03:07 12:00:{:02}", second)}});
  }
  static CardPictures read(const std::vector<fs::path>& files) { return read_card(files); }
  static std::vector<std::string> names(const CardPictures& card) {
    std::vector<std::string> names;
    for (const CardShot& shot : card.shots) names.push_back(shot[0].file.filename().string());
    return names;
  }

  TestDirectory card_;
};

TEST_F(CardPicturesTest, TheTimeIsThatOfExifElseOfTheFile) {
  struct Case {
    Tags tags;
    Duration off;  // from noon
    std::string source;
    double resolution_s;
  };
  const std::vector<Case> cases{
      {{}, 0s, "Exif local time", 1.0},
      {{{kSubSeconds, "7"}}, 700ms, "Exif local time", 0.1},
      {{{kSubSeconds, "070"}}, 70ms, "Exif local time", 0.001},
      {{{kOffset, "+02:00"}}, -2h, "Exif time", 1.0},
      {{{kOffset, "-05:30"}}, 5h + 30min, "Exif time", 1.0},
      {{{kOffset, ""}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "   :  "}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "+2:00"}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "+99:00"}}, 0s, "Exif local time", 1.0},
      {{{kOffset, "0200"}}, 0s, "Exif local time", 1.0},
  };
  for (const auto& [tags, off, source, resolution_s] : cases) {
    Tags all = tags;
    all[kDate] = kNoonText;
    const CardPictures card = read({picture("a.jpg", all)});
    const std::string shown = testing::PrintToString(tags);
    EXPECT_EQ(card.shots.at(0)[0].time, kNoon + off) << shown;
    EXPECT_EQ(card.time_source, source) << shown;
    EXPECT_DOUBLE_EQ(card.resolution_s, resolution_s) << shown;
  }
  for (const char* const nonsense :
       {"0000:00:00 00:00:00", "    :  :     :  :  ", "2026:02:30 12:00:00", "2026:03:07 24:00:00",
        "2026-03-07 12:30:05", "2026:03:07", "", "2026:03:07 12:30:-5"}) {
    const fs::path file = picture("a.jpg", {{kDate, nonsense}});
    const CardPictures card = read({file});
    EXPECT_EQ(card.time_source, "file time") << nonsense;
    EXPECT_EQ(card.resolution_s, 2.0) << nonsense;
    const auto written = std::chrono::file_clock::to_sys(fs::last_write_time(file));
    EXPECT_LT(std::chrono::abs(card.shots.at(0)[0].time - written), 1ms) << nonsense;
  }
}

TEST_F(CardPicturesTest, ADamagedFileNeverThrows) {
  const auto whole = picture("a.jpg", {{kDate, kNoonText}, {kOffset, "+02:00"}});
  const std::string bytes = read_file(whole);
  const auto damaged = card_ / "damaged.jpg";
  for (std::size_t at = 0; at < std::min<std::size_t>(bytes.size(), 300); at += 3) {
    std::ofstream(damaged, std::ios::binary) << bytes.substr(0, at);
    EXPECT_NO_THROW(read({damaged})) << "cut at " << at;
    std::string changed = bytes;
    changed[at] = static_cast<char>(~changed[at]);
    std::ofstream(damaged, std::ios::binary) << changed;
    EXPECT_NO_THROW(read({damaged})) << "changed at " << at;
  }
}

TEST_F(CardPicturesTest, TheTimesOfAllAreFromOneSource) {
  const fs::path utc = picture("utc.jpg", {{kDate, kNoonText}, {kOffset, "+02:00"}});
  const fs::path local = picture("local.jpg", {{kDate, "2026:03:07 12:30:07"}});
  const CardPictures card = read({utc, local});
  EXPECT_EQ(card.time_source, "Exif local time");
  EXPECT_EQ(card.shots.at(1)[0].time - card.shots.at(0)[0].time, 2s);
  const fs::path odd = picture("odd.jpg", Tags{});
  for (const auto& files : {std::vector{local, odd}, std::vector{odd, local}}) {
    EXPECT_THAT([&] { read(files); }, ThrowsMessage<Error>(HasSubstr("odd.jpg: no Exif time")));
  }
}

TEST_F(CardPicturesTest, ShotsComeInOrderOfTimeThenNameFromADirectoryAndThoseInIt) {
  picture("DCIM/100RICOH/R2.JPG", 7);
  picture("DCIM/100RICOH/R9.JPG", 3);
  picture("DCIM/R1.jpg", 7);
  picture("DCIM/._R2.jpg", 2);
  write_test_picture(card_ / "DCIM/thumb.bmp");
  const CardPictures card = read({card_ / "DCIM"});
  EXPECT_THAT(names(card), ElementsAre("R9.JPG", "R1.jpg", "R2.JPG"));
  EXPECT_EQ(card.shots[0][0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, FrontAndBackFilesOfAShotArePaired) {
  const CardPictures card =
      read({picture("100GBACK/GPBK0002.JPG", 6), picture("100GFRNT/GPFR0001.JPG", 1),
            picture("100GFRNT/GPFR0002.JPG", 6), picture("100GBACK/GPBK0001.JPG", 2),
            // The same number in another folder is another shot.
            picture("101GFRNT/GF010001.JPG", 9), picture("101GBACK/GB010001.JPG", 9),
            picture("102GFRNT/GF010001.JPG", 11), picture("102GBACK/GB010001.JPG", 11),
            picture("102GFRNT/GF010003.JPG", 20)});
  EXPECT_THAT(names(card),
              ElementsAre("GPFR0001.JPG", "GPFR0002.JPG", "GF010001.JPG", "GF010001.JPG"));
  EXPECT_EQ(card.shots[1][0].lens, FrameLens::kFront);
  EXPECT_EQ(card.shots[1][1].lens, FrameLens::kBack);
  EXPECT_EQ(card.shots[1][1].file.filename(), "GPBK0002.JPG");
  EXPECT_THAT(card.unpaired, ElementsAre(card_ / "102GFRNT/GF010003.JPG"));
}

TEST_F(CardPicturesTest, FilesArePairedOnlyIfAllAreNamedAsHalves) {
  const CardPictures card = read({picture("GPFR0001.JPG", 1), picture("R0001.JPG", 3)});
  EXPECT_EQ(card.shots.size(), 2U);
  EXPECT_EQ(card.shots[0][0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, InvalidArgumentsAreNamed) {
  EXPECT_THAT([] { read({}); }, ThrowsMessage<UsageError>(HasSubstr("no pictures given")));
  EXPECT_THAT([&] { read({card_.path()}); }, ThrowsMessage<UsageError>(HasSubstr("no .jpg")));
  const fs::path file = picture("R1.JPG", 1);
  EXPECT_THAT(
      [&] {
        read({file, card_ / "./R1.JPG"});
      },
      ThrowsMessage<UsageError>(HasSubstr("given twice")));
  EXPECT_THAT([&] { read({card_ / "gone.jpg"}); }, ThrowsMessage<Error>(HasSubstr("gone.jpg")));
}

}  // namespace
}  // namespace raywalk::capture
