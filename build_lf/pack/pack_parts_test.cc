#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/partial_room.h"
#include "build_lf/pack/test_capture.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class PackPartsTest : public ::testing::Test {
 protected:
  PackPartsTest() {
    for (const int frame : {0, 3, 20}) capture_.write_distance_map(frame, {32, 16});
    options_.frames = capture_.list();
    options_.distances = capture_.distances();
    options_.out = capture_.room();
  }

  TestCapture capture_;
  PackOptions options_;
};

TEST_F(PackPartsTest, MakeTheSameRoomAsOneRun) {
  PackOptions plain = options_;
  plain.out = capture_.root() / "plain.lf";
  pack_room(plain);

  pack_part(options_, {3, 3});
  pack_part(options_, {1, 3});
  EXPECT_THAT(pack_part(options_, {1, 3}), HasSubstr("packed before"));
  EXPECT_THAT(pack_part(options_, {1, 5}), HasSubstr("is empty: the room has 4 lines"));
  EXPECT_FALSE(fs::exists(options_.out));
  pack_room(options_);
  EXPECT_EQ(checksums_of_files(options_.out), checksums_of_files(plain.out));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackPartsTest, AreTakenOverByARunOfItsOwn) {
  pack_part(options_, {2, 3});
  fs::path packed;
  for (const auto& entry : fs::directory_iterator(capture_.partial() / "lines")) {
    packed = entry.path().filename();
  }
  const fs::file_time_type written = fs::last_write_time(capture_.partial() / "lines" / packed);
  pack_room(options_);
  EXPECT_EQ(fs::last_write_time(options_.out / "lines" / packed), written);
}

TEST_F(PackPartsTest, OfOtherFramesAreRefusedUnlessForced) {
  pack_part(options_, {1, 3});
  capture_.write_frame(5, {TestCapture::kWidth, TestCapture::kHeight});
  EXPECT_THAT(error_of([&] { pack_part(options_, {2, 3}); }), HasSubstr("of other frames"));
  EXPECT_THAT(error_of([&] { pack_room(options_); }), HasSubstr("of other frames"));
  options_.replace = true;
  EXPECT_THAT(pack_part(options_, {1, 2}), HasSubstr("2 lines, packed"));
}

// What another machine is writing is left alone, as is what a living process writes here.
TEST_F(PackPartsTest, UnfinishedVolumesOfLivingPartsStay) {
  const PartialRoom other(options_.out, plan_pack(options_).fingerprint, false,
                          FileLock::Use::kShared);
  const fs::path elsewhere = capture_.partial() / "lines" / ".x0.0123abcd-77.0.partial.h5";
  std::ofstream(elsewhere) << "half";
  for (const int index : {1, 2, 3}) pack_part(options_, {index, 3});
  EXPECT_TRUE(fs::exists(elsewhere));
  EXPECT_THAT(error_of([&] { pack_room(options_); }), HasSubstr("another raywalk-build-lf"));
  EXPECT_TRUE(fs::exists(elsewhere));
}

}  // namespace
}  // namespace raywalk::build_lf
