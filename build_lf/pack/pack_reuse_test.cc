#include <gmock/gmock.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "build_lf/pack/free_space.h"
#include "build_lf/pack/room_folder.h"
#include "build_lf/pack/test_pack.h"
#include "build_lf/pack/volume_writer.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// What a pack run takes over: of a stopped run, of parts, and of the room that it replaces.
constexpr std::array kIds{"x0", "x1", "z0", "z1"};

class PackReuseTest : public PackTest {
 protected:
  // Leaves two of the four lines finished, as a stopped run does, and a volume that was being
  // written.
  void stop_half_way() const {
    pack();
    fs::rename(capture_.room(), capture_.partial());
    for (const char* id : {"z0", "z1"}) fs::remove(line_volume_path(capture_.partial(), id));
    fs::remove(manifest_path(capture_.partial()));
    std::ofstream(capture_.partial() / "lines" / ".z0.00000000-1.0.partial.h5") << "half";
  }

  // The files of volumes, by "x0" and "maps of x0"; a file that is written anew is another one.
  std::map<std::string, fs::file_time_type> volumes() const {
    std::map<std::string, fs::file_time_type> times;
    for (const std::string id : kIds) {
      times[id] = fs::last_write_time(line_volume_path(capture_.room(), id));
      const fs::path maps = distance_volume_path(capture_.room(), id);
      if (fs::exists(maps)) times["maps of " + id] = fs::last_write_time(maps);
    }
    return times;
  }
  // Packs again over the room. The volumes that were written anew; all files must be those of a
  // room packed from nothing.
  std::vector<std::string> packed_anew() {
    const auto before = volumes();
    options_.replace = true;
    pack();
    PackOptions fresh = options_;
    fresh.out = capture_.root() / "new.lf";
    pack_room(fresh);
    EXPECT_EQ(checksums_of_files(capture_.room()), checksums_of_files(fresh.out));
    fs::remove_all(fresh.out);
    std::vector<std::string> anew;
    for (const auto& [volume, time] : volumes()) {
      if (time != before.at(volume)) anew.push_back(volume);
    }
    return anew;
  }
};

TEST_F(PackReuseTest, AStoppedRunIsResumedInTheSpaceThatTheRestNeeds) {
  stop_half_way();
  const auto written = fs::last_write_time(line_volume_path(capture_.partial(), "x0"));
  options_.free_bytes = [](const fs::path&) { return TestCapture::kRayBytes / 2 - 1; };
  EXPECT_THAT(error(), HasSubstr("needs 87 kB besides the 86 kB that are there, 86 kB are free"));
  options_.free_bytes = [](const fs::path& room) {
    for (const auto& entry : fs::directory_iterator(room / "lines")) {
      EXPECT_FALSE(entry.path().filename().string().starts_with('.')) << "counted as space";
    }
    return TestCapture::kRayBytes / 2;
  };
  EXPECT_EQ(verify_room(pack()).panoramas, kStations);
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_FALSE(fs::exists(capture_.partial()));
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(capture_.room())) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_THAT(names, ElementsAre("lines", "manifest.json", "x0.h5", "x1.h5", "z0.h5", "z1.h5"));
}

TEST_F(PackReuseTest, OtherInputsOfAFinishedLineAreRefusedUnlessForced) {
  stop_half_way();
  capture_.write_frame(20, {64, 32});  // of z0, which is not packed yet
  capture_.write_frame(5, {64, 32});   // of x1
  EXPECT_THAT(error(), ::testing::AllOf(HasSubstr(capture_.partial().string()),
                                        HasSubstr("of other frames"), HasSubstr("remove it")));
  EXPECT_TRUE(fs::exists(line_volume_path(capture_.partial(), "x0")));
  options_.replace = true;
  EXPECT_EQ(verify_room(pack()).panoramas, kStations);
}

TEST_F(PackReuseTest, EveryInputCounts) {
  capture_.write_distance_map(0, {32, 16});
  const std::vector<LineInputs> first = plan_pack(options_).inputs;
  capture_.write_list("# a note\n");
  EXPECT_EQ(plan_pack(options_).inputs, first);
  options_.form.kind = RayForm::Kind::kLossless;
  EXPECT_NE(plan_pack(options_).inputs, first);
  options_.form = {};
  options_.distances = capture_.distances();
  EXPECT_NE(plan_pack(options_).inputs, first);
}

TEST_F(PackReuseTest, ADamagedFrameCostsNoMoreThanItsLine) {
  for (const int frame : {0, 26}) {
    fs::resize_file(capture_.path(frame), fs::file_size(capture_.path(frame)) / 2);
    EXPECT_THAT(error(), HasSubstr(capture_.path(frame).filename().string()));
    EXPECT_FALSE(fs::exists(capture_.room()));
    capture_.write_frame(frame, {64, 32});
  }
  EXPECT_TRUE(fs::exists(line_volume_path(capture_.partial(), "x0")));
  EXPECT_EQ(verify_room(pack()).panoramas, kStations);
}

TEST_F(PackReuseTest, PartsMakeTheSameRoomAsOneRun) {
  give_maps({0, 3, 20});
  PackOptions plain = options_;
  plain.out = capture_.root() / "plain.lf";
  pack_room(plain);
  pack_part(options_, {3, 3});
  pack_part(options_, {1, 3});
  EXPECT_THAT(pack_part(options_, {1, 3}), HasSubstr("packed before"));
  EXPECT_THAT(pack_part(options_, {1, 5}), HasSubstr("is empty: the room has 4 lines"));
  EXPECT_FALSE(fs::exists(options_.out));
  const auto written = fs::last_write_time(line_volume_path(capture_.partial(), "x0"));
  pack_room(options_);
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(checksums_of_files(options_.out), checksums_of_files(plain.out));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackReuseTest, PartsOfOtherFramesAreRefusedUnlessForced) {
  pack_part(options_, {1, 3});
  capture_.write_frame(8, {64, 32});  // of x0, which is packed
  EXPECT_THAT(error_of([&] { pack_part(options_, {2, 3}); }), HasSubstr("of other frames"));
  EXPECT_THAT(error(), HasSubstr("of other frames"));
  options_.replace = true;
  EXPECT_THAT(pack_part(options_, {1, 2}), HasSubstr("2 lines, packed"));
}

// What another machine is writing is left alone, as is what a living process writes here.
TEST_F(PackReuseTest, UnfinishedVolumesOfLivingPartsStay) {
  const RoomFolder other(options_.out, {}, false, FileLock::Use::kShared);
  const fs::path elsewhere = capture_.partial() / "lines" / ".x0.0123abcd-77.0.partial.h5";
  std::ofstream(elsewhere) << "half";
  for (const int index : {1, 2, 3}) pack_part(options_, {index, 3});
  EXPECT_TRUE(fs::exists(elsewhere));
  EXPECT_THAT(error(), HasSubstr("another raywalk-build-lf"));
  capture_.write_frame(8, {64, 32});
  options_.replace = true;
  EXPECT_THAT(error_of([&] { pack_part(options_, {1, 3}); }), HasSubstr("of other frames"));
  EXPECT_TRUE(fs::exists(elsewhere));
}

TEST_F(PackReuseTest, OnlyALineThatWasCapturedAgainIsPackedAnew) {
  give_maps({0, 3, 20});
  pack();
  EXPECT_TRUE(is_packed_from(capture_.room(), plan_pack(options_)));
  EXPECT_THAT(packed_anew(), ::testing::IsEmpty());
  // Frame 2 is of x1, frame 8 of x0; written again with the pixels of others of the same size.
  fs::copy_file(capture_.path(25), capture_.path(2), fs::copy_options::overwrite_existing);
  EXPECT_FALSE(is_packed_from(capture_.room(), plan_pack(options_)));
  EXPECT_THAT(packed_anew(), ElementsAre("x1"));
  capture_.write_distance_map(20, {32, 16});
  EXPECT_THAT(packed_anew(), ElementsAre("maps of z0"));
  capture_.write_rows("file,x,y,z", [](const TestCapture::Row& row) {
    return fmt::format("{},{},0,{}", row.file, row.x_m, row.file == "right_3.png" ? 0.01 : row.z_m);
  });
  EXPECT_THAT(packed_anew(), ElementsAre("maps of z1", "z1"));
  // A volume of another line, and one that does not say what it was made from.
  fs::copy_file(line_volume_path(capture_.room(), "x1"), line_volume_path(capture_.room(), "x0"),
                fs::copy_options::overwrite_existing);
  fs::resize_file(line_volume_path(capture_.room(), "z0"), 100);
  EXPECT_THAT(packed_anew(), ElementsAre("x0", "z0"));
}

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

TEST(RequireSpace, SizesHaveAFittingUnitAndDiffer) {
  const auto error_for = [](std::uint64_t needed, std::optional<std::uint64_t> free) {
    return error_of([&] { require_space("room.lf.partial", {.needed = needed}, free); });
  };
  EXPECT_THAT(error_for(39'000'000, 31'000'000),
              HasSubstr("room.lf.partial: the room needs 39 MB, 31 MB are free"));
  EXPECT_THAT(error_for(70'000'001, 70'000'000), HasSubstr("needs 71 MB, 70 MB are free"));
  EXPECT_THAT(error_for(12'400'000'000'000, 900), HasSubstr("13 TB, 0 TB"));
  EXPECT_THAT(error_for(9'999, 0), HasSubstr("9999 bytes, 0 bytes"));
  EXPECT_EQ(error_for(1000, std::nullopt), "no error");
}

}  // namespace
}  // namespace raywalk::build_lf
