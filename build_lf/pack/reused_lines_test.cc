#include "build_lf/pack/reused_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <string>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_capture.h"
#include "core/files/atomic_output.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
namespace fs = std::filesystem;

ino_t inode_of(const fs::path& file) {
  struct stat status {};
  EXPECT_EQ(stat(file.c_str(), &status), 0) << file;
  return status.st_ino;
}

// The bytes of every file, by its path in the folder.
std::map<std::string, std::string> content_of(const fs::path& folder) {
  std::map<std::string, std::string> content;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      content[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
    }
  }
  return content;
}

class ReusedLinesTest : public ::testing::Test {
 protected:
  ReusedLinesTest() {
    for (int frame : {0, 3, 20}) capture_.write_distance_map(frame, {32, 16});
    pack(capture_.room());
    for (const char* id : kIds) {
      packed_[id] = inode_of(line_volume_path(capture_.room(), id));
      const fs::path maps = distance_volume_path(capture_.room(), id);
      if (fs::exists(maps)) packed_maps_[id] = inode_of(maps);
    }
  }
  void pack(const fs::path& room) const {
    pack_room({.frames = capture_.list(),
               .out = room,
               .distances = capture_.distances(),
               .replace = room == capture_.room()});
  }
  // Packs again over the room. The lines that were written anew; all files must be those of a room
  // packed from nothing.
  std::vector<std::string> repacked() const {
    pack(capture_.room());
    pack(capture_.root() / "new.lf");
    EXPECT_EQ(content_of(capture_.room()), content_of(capture_.root() / "new.lf"));
    fs::remove_all(capture_.root() / "new.lf");
    std::vector<std::string> anew;
    for (const char* id : kIds) {
      if (inode_of(line_volume_path(capture_.room(), id)) != packed_.at(id)) anew.emplace_back(id);
      if (!packed_maps_.contains(id)) continue;
      const ino_t maps = inode_of(distance_volume_path(capture_.room(), id));
      if (maps != packed_maps_.at(id)) anew.push_back(std::string("maps of ") + id);
    }
    return anew;
  }

  static constexpr std::array kIds{"x0", "x1", "z0", "z1"};
  TestCapture capture_;
  std::map<std::string, ino_t> packed_{};  // volumes of the room as first packed
  std::map<std::string, ino_t> packed_maps_{};
};

TEST_F(ReusedLinesTest, OnlyALineThatWasCapturedAgainIsPackedAnew) {
  EXPECT_THAT(repacked(), ElementsAre());
  // Frame 2 is of x1, frame 8 of x0; written again with the pixels of others of the same size.
  fs::copy_file(capture_.path(25), capture_.path(2), fs::copy_options::overwrite_existing);
  EXPECT_THAT(repacked(), ElementsAre("x1"));
  capture_.write_distance_map(20, {32, 16});
  EXPECT_THAT(repacked(), ElementsAre("x1", "maps of z0"));
}

TEST_F(ReusedLinesTest, ALineWithOtherPlacesIsPackedAnew) {
  std::string list = read_file(capture_.list());
  const std::string row = "right_3.png,0.5,0,0\n";
  ASSERT_NE(list.find(row), std::string::npos) << list;
  list.replace(list.find(row), row.size(), "right_3.png,0.5,0,0.01\n");
  write_file_atomically(capture_.list(), list);
  EXPECT_THAT(repacked(), ElementsAre("z1", "maps of z1"));
}

TEST_F(ReusedLinesTest, AVolumeThatIsNotTheRoomsIsNotTakenOver) {
  fs::copy_file(line_volume_path(capture_.room(), "x1"), line_volume_path(capture_.room(), "x0"),
                fs::copy_options::overwrite_existing);
  packed_["x0"] = 0;
  EXPECT_THAT(repacked(), ElementsAre("x0"));
}

TEST_F(ReusedLinesTest, WithoutTheRecordOfItsInputsARoomIsPackedAnew) {
  write_file_atomically(capture_.room() / "inputs.json", "{\"format_version\": 99}");
  EXPECT_EQ(repacked().size(), packed_.size() + packed_maps_.size());
}

}  // namespace
}  // namespace raywalk::build_lf
