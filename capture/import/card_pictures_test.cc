#include "capture/import/card_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/import/test_pictures.h"
#include "core/base/error.h"
#include "core/files/test_directory.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

class CardPicturesTest : public testing::Test {
 protected:
  // A picture taken `second` seconds after noon.
  fs::path picture(const std::string& name, int second) {
    const fs::path file = card_ / name;
    fs::create_directories(file.parent_path());
    write_test_picture(file);
    write_test_exif(file, {{0x9003, fmt::format("2026:03:07 12:00:{:02}", second)}});
    return file;
  }
  static std::vector<std::string> names(const CardPictures& card) {
    std::vector<std::string> names;
    for (const CardShot& shot : card.shots) {
      names.push_back(shot.files.front().file.filename().string());
    }
    return names;
  }

  TestDirectory card_;
};

TEST_F(CardPicturesTest, ShotsComeInOrderOfTimeThenName) {
  const std::vector<fs::path> files{picture("R2.JPG", 7), picture("R9.JPG", 3),
                                    picture("R1.JPG", 7)};
  const CardPictures card = read_card(files);
  EXPECT_THAT(names(card), ElementsAre("R9.JPG", "R1.JPG", "R2.JPG"));
  EXPECT_EQ(card.source, PictureTimeSource::kExifLocal);
  EXPECT_EQ(card.resolution_s, 1.0);
  EXPECT_EQ(card.shots[0].files[0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, ADirectoryIsSearchedRecursively) {
  picture("DCIM/100RICOH/R1.JPG", 1);
  picture("DCIM/R2.jpg", 2);
  picture("DCIM/._R2.jpg", 2);
  write_test_picture(card_ / "DCIM/thumb.bmp");
  const std::vector<fs::path> directory{card_ / "DCIM"};
  EXPECT_THAT(names(read_card(directory)), ElementsAre("R1.JPG", "R2.jpg"));
}

TEST_F(CardPicturesTest, FrontAndBackFilesOfAShotArePaired) {
  const std::vector<fs::path> files{
      picture("100GBACK/GPBK0002.JPG", 6), picture("100GFRNT/GPFR0001.JPG", 1),
      picture("100GFRNT/GPFR0002.JPG", 6), picture("100GBACK/GPBK0001.JPG", 2)};
  const CardPictures card = read_card(files);
  ASSERT_EQ(card.shots.size(), 2U);
  EXPECT_THAT(names(card), ElementsAre("GPFR0001.JPG", "GPFR0002.JPG"));
  EXPECT_EQ(card.shots[1].files[0].lens, FrameLens::kFront);
  EXPECT_EQ(card.shots[1].files[1].lens, FrameLens::kBack);
  EXPECT_EQ(card.shots[1].files[1].file.filename(), "GPBK0002.JPG");
  EXPECT_TRUE(card.unpaired.empty());
}

TEST_F(CardPicturesTest, TheSameNumberInAnotherFolderIsAnotherShot) {
  const std::vector<fs::path> files{
      picture("100GFRNT/GF010001.JPG", 1), picture("100GBACK/GB010001.JPG", 1),
      picture("101GFRNT/GF010001.JPG", 9), picture("101GBACK/GB010001.JPG", 9)};
  EXPECT_EQ(read_card(files).shots.size(), 2U);
}

TEST_F(CardPicturesTest, AFrontWithoutBackIsUnpaired) {
  const std::vector<fs::path> files{picture("GPFR0001.JPG", 1), picture("GPBK0001.JPG", 1),
                                    picture("GPFR0002.JPG", 6)};
  const CardPictures card = read_card(files);
  EXPECT_EQ(card.shots.size(), 1U);
  EXPECT_THAT(card.unpaired, ElementsAre(card_ / "GPFR0002.JPG"));
}

TEST_F(CardPicturesTest, FilesArePairedOnlyIfAllAreNamedAsHalves) {
  const std::vector<fs::path> files{picture("GPFR0001.JPG", 1), picture("R0001.JPG", 3)};
  const CardPictures card = read_card(files);
  EXPECT_EQ(card.shots.size(), 2U);
  EXPECT_EQ(card.shots[0].files[0].lens, FrameLens::kBoth);
}

TEST_F(CardPicturesTest, InvalidArgumentsAreNamed) {
  EXPECT_THAT([] { read_card({}); }, ThrowsMessage<UsageError>(HasSubstr("no pictures given")));
  const std::vector<fs::path> empty{card_.path()};
  EXPECT_THAT([&] { read_card(empty); }, ThrowsMessage<UsageError>(HasSubstr("no .jpg")));
  const std::vector<fs::path> twice{picture("R1.JPG", 1), card_ / "./R1.JPG"};
  EXPECT_THAT([&] { read_card(twice); }, ThrowsMessage<UsageError>(HasSubstr("given twice")));
  const std::vector<fs::path> missing{card_ / "gone.jpg"};
  EXPECT_THAT([&] { read_card(missing); }, ThrowsMessage<Error>(HasSubstr("gone.jpg")));
}

}  // namespace
}  // namespace raywalk::capture
