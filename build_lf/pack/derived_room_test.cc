#include "build_lf/pack/derived_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_pack.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/hdf5_file.h"
#include "core/room/room.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr RayForm kLossless{RayForm::Kind::kLossless, 0};
constexpr RayForm kJpeg{RayForm::Kind::kJpeg, 95};

class RepackRoomTest : public PackTest {
 protected:
  RepackRoomTest() {
    give_all_maps();
    options_.replace = true;
    pack();
  }

  static fs::path repacked(const fs::path& from, const RayForm& form) {
    const fs::path out = default_repacked_name(from, form);
    repack_room({.room = from, .out = out, .form = form});
    return out;
  }
  // The largest difference of any ray of two rooms.
  static int largest_difference(const Room& a, const Room& b) {
    int largest = 0;
    for (int line = 0; line < static_cast<int>(a.grid().lines.size()); ++line) {
      for (int station = 0; station < a.volume(line).stations(); ++station) {
        const TileReading reading;
        const auto rays = a.volume(line).columns(station);
        const auto others = b.volume(line).columns(station);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          largest = std::max(largest, std::abs(int{rays[i]} - int{others[i]}));
        }
      }
    }
    return largest;
  }
};

TEST_F(RepackRoomTest, EveryFormCanBeMadeOfEveryOther) {
  const Room raw = Room::open(capture_.room());
  write_file_atomically(capture_.room() / "measured.json", "{}");
  write_file_atomically(capture_.room() / "notes.json", "kept");
  const fs::path lossless = repacked(capture_.room(), kLossless);
  const fs::path jpeg = repacked(lossless, kJpeg);
  const fs::path back = repacked(lossless, {});
  for (const fs::path& room : {lossless, jpeg, back}) {
    const VerifiedCounts counts = verify_room(Room::open(room));
    EXPECT_EQ(counts.panoramas, info_of(raw).stations);
    EXPECT_EQ(counts.distance_maps, info_of(raw).distance_maps);
    EXPECT_FALSE(fs::exists(room / "measured.json"));
    EXPECT_EQ(read_file(room / "notes.json"), "kept");
    EXPECT_FALSE(fs::exists(room.string() + ".partial"));
  }
  EXPECT_EQ(largest_difference(raw, Room::open(lossless)), 0);
  EXPECT_EQ(largest_difference(raw, Room::open(back)), 0);
  EXPECT_EQ(Room::open(lossless).manifest().rays_sha256, raw.manifest().rays_sha256);
  EXPECT_NE(Room::open(jpeg).manifest().rays_sha256, raw.manifest().rays_sha256);
  EXPECT_EQ(info_of(Room::open(jpeg)).compression, "jpeg:95");
  // A form that a room has already is copied, without a further loss.
  const fs::path again = capture_.room().parent_path() / "again.lf";
  repack_room({.room = jpeg, .out = again, .form = kJpeg});
  EXPECT_EQ(largest_difference(Room::open(jpeg), Room::open(again)), 0);
}

TEST_F(RepackRoomTest, PackingStoresTheSameAsRepacking) {
  const Room repacked_room = Room::open(repacked(capture_.room(), kJpeg));
  options_.form = kJpeg;
  const Room packed = pack();
  EXPECT_EQ(packed.manifest().rays_sha256, repacked_room.manifest().rays_sha256);
  EXPECT_EQ(largest_difference(packed, repacked_room), 0);
  EXPECT_EQ(verify_room(packed).distance_maps, verify_room(repacked_room).distance_maps);
  EXPECT_TRUE(packed.distances(0).compressed());
}

TEST_F(RepackRoomTest, DamagedMapsAreErrors) {
  const fs::path room = repacked(capture_.room(), kLossless);
  const fs::path file = distance_volume_path(room, Room::open(room).grid().lines[0].id);
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekp(static_cast<std::streamoff>(fs::file_size(file) / 2));
  stream.write("\x55\xaa\x55", 3);
  stream.close();
  EXPECT_THROW(verify_room(Room::open(room)), Error);
}

TEST_F(RepackRoomTest, AnExistingRoomAndOneOfOtherInputsAreKept) {
  const fs::path made = repacked(capture_.room(), kLossless);
  EXPECT_THROW(repacked(capture_.room(), kLossless), Error);
  const fs::path partial = default_repacked_name(capture_.room(), kJpeg).string() + ".partial";
  fs::rename(made, partial);
  EXPECT_THROW(repacked(capture_.room(), kJpeg), Error);
  EXPECT_TRUE(fs::exists(manifest_path(partial)));
  fs::remove_all(partial);
  EXPECT_NO_THROW(verify_room(Room::open(repacked(capture_.room(), kLossless))));
}

}  // namespace
}  // namespace raywalk::build_lf
