#include "build_lf/pack/room_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class RoomFolderTest : public ::testing::Test {
 protected:
  static std::vector<PlannedVolume> plan(const std::string& inputs) {
    return {{fs::path("lines") / "x0.h5", inputs}, {fs::path("lines") / "x1.h5", inputs}};
  }
  std::string error_with(const std::string& inputs, bool replace = false) const {
    return error_of([&] { const RoomFolder folder(out_, plan(inputs), replace); });
  }

  TestDirectory directory_;
  fs::path out_ = directory_ / "room.lf";
  fs::path partial_ = directory_ / "room.lf.partial";
};

TEST_F(RoomFolderTest, NothingIsLeftWithoutAFinishedVolume) {
  { const RoomFolder folder(out_, plan("a")); }
  EXPECT_EQ(directory_.entries(), 0U);
  // What Raywalk did not make stays.
  fs::create_directories(partial_ / "lines");
  write_file_atomically(partial_ / "lines" / "thesis.txt", "mine");
  { const RoomFolder folder(out_, plan("a")); }
  EXPECT_EQ(read_file(partial_ / "lines" / "thesis.txt"), "mine");
}

TEST_F(RoomFolderTest, AVolumeThatIsNotPlannedIsOfOtherInputs) {
  {
    const RoomFolder stopped(out_, plan("a"));
    Hdf5File file = Hdf5File::create(partial_ / "lines" / "z0.h5");
    file.write_attribute("/", kInputsAttribute, std::string("a"));
    file.close();
  }
  EXPECT_THAT(error_with("a"), HasSubstr("of other frames"));
  // A room that someone gave this name is never taken apart.
  write_file_atomically(partial_ / "manifest.json", "{}");
  EXPECT_THAT(error_with("a", true), HasSubstr("of other frames"));
  EXPECT_TRUE(fs::exists(partial_ / "lines" / "z0.h5"));
}

TEST_F(RoomFolderTest, OnlyARoomIsReplaced) {
  fs::create_directory(out_);
  write_file_atomically(out_ / "thesis.txt", "mine");
  EXPECT_THAT(error_with("a", true), HasSubstr("not a room"));
  EXPECT_EQ(read_file(out_ / "thesis.txt"), "mine");
  EXPECT_FALSE(fs::exists(partial_));
}

TEST_F(RoomFolderTest, ARoomThatAppearsMeanwhileIsNotReplaced) {
  RoomFolder folder(out_, {});
  fs::create_directory(out_);
  EXPECT_THROW(folder.complete(RoomManifest{}), Error);
  EXPECT_TRUE(fs::is_empty(out_));
}

}  // namespace
}  // namespace raywalk::build_lf
