#include "render/web/export_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class ExportFolderTest : public ::testing::Test {
 protected:
  fs::path out() const { return directory_ / "web"; }
  fs::path partial() const { return directory_ / "web.partial"; }
  std::string error(bool replace) const {
    return error_of([&] { const ExportFolder folder(out(), replace); });
  }
  // A complete export.
  void export_once(const std::string& title, bool replace = false) const {
    ExportFolder folder(out(), replace);
    write_file_atomically(folder.directory() / "stations" / "0000.jpg", title);
    write_file_atomically(folder.directory() / "index.html", title);
    write_file_atomically(folder.directory() / "manifest.json",
                          "{\"format\": \"raywalk-web\", \"title\": \"" + title + "\"}");
    folder.complete();
  }

  TestDirectory directory_;
};

TEST_F(ExportFolderTest, AppearsOnlyWhenComplete) {
  {
    ExportFolder folder(out(), false);
    EXPECT_TRUE(fs::is_directory(folder.directory() / "stations"));
    EXPECT_FALSE(fs::exists(out()));
    write_file_atomically(folder.directory() / "index.html", "page");
    folder.complete();
  }
  EXPECT_EQ(read_file(out() / "index.html"), "page");
  EXPECT_FALSE(fs::exists(out() / "lock"));
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(ExportFolderTest, LeavesNothingWhereItFails) {
  { const ExportFolder folder(out(), false); }
  EXPECT_EQ(directory_.entries(), 0U);
}

TEST_F(ExportFolderTest, ReplacesAnEarlierExportOnlyWhenAsked) {
  export_once("first");
  EXPECT_THAT(error(false), HasSubstr("--out"));
  export_once("second", true);
  EXPECT_EQ(read_file(out() / "index.html"), "second");
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(ExportFolderTest, KeepsTheEarlierExportWhereTheNewOneFails) {
  export_once("first");
  { const ExportFolder folder(out(), true); }
  EXPECT_EQ(read_file(out() / "index.html"), "first");
  EXPECT_EQ(directory_.entries(), 1U);
}

TEST_F(ExportFolderTest, ReplacesNothingElse) {
  export_once("first");
  write_file_atomically(out() / "stations" / "diary.doc", "mine");
  EXPECT_THAT(error(true), HasSubstr("diary.doc"));
  fs::remove(out() / "stations" / "diary.doc");
  make_directories(out() / "photos");
  EXPECT_THAT(error(true), HasSubstr("photos"));
  fs::remove(out() / "photos");
  EXPECT_EQ(error(true), "no error");
  write_file_atomically(out() / "manifest.json", "{\"format\": \"raywalk-room\"}");
  EXPECT_THAT(error(true), HasSubstr("not an exported room"));
}

TEST_F(ExportFolderTest, StartsAfreshOverWhatAKilledRunLeft) {
  make_directories(partial() / "stations");
  write_file_atomically(partial() / "lock", "");
  write_file_atomically(partial() / "stations" / "0000.jpg", "half");
  ExportFolder folder(out(), false);
  EXPECT_FALSE(fs::exists(folder.directory() / "stations" / "0000.jpg"));
}

TEST_F(ExportFolderTest, DoesNotRemoveWhatItDidNotWrite) {
  make_directories(partial());
  write_file_atomically(partial() / "diary.txt", "mine");
  EXPECT_THAT(error(false), HasSubstr("diary.txt"));
  write_file_atomically(partial() / "lock", "");
  write_file_atomically(partial() / "diary.doc", "mine");
  EXPECT_THAT(error(false), HasSubstr("diary.doc"));
  EXPECT_EQ(read_file(partial() / "diary.doc"), "mine");
}

TEST_F(ExportFolderTest, OnlyOneRunWritesIt) {
  const ExportFolder first(out(), false);
  write_file_atomically(first.directory() / "stations" / "0000.jpg", "first");
  EXPECT_THAT(error(false), HasSubstr("another run"));
  EXPECT_EQ(read_file(first.directory() / "stations" / "0000.jpg"), "first");
}

}  // namespace
}  // namespace raywalk::render
