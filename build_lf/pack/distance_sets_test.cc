#include "build_lf/pack/distance_sets.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "build_lf/pack/derived_room.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_pack.h"
#include "build_lf/pack/volume_writer.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/room/room.h"
#include "core/room/tiled_rays.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr PanoramaSize kMapSize{32, 16};

// A room of four lines packed with distances at every station.
class DistanceSetsTest : public PackTest {
 protected:
  DistanceSetsTest() {
    give_all_maps();
    pack();
  }

  fs::path volume(const std::string& line, DistanceKind kind = DistanceKind::kGiven) const {
    return distance_volume_path(room_, line, kind);
  }
  Room opened() const { return Room::open(room_); }
  std::string open_error() const {
    return error_of([&] { opened(); });
  }
  std::string verify_error() const {
    return error_of([&] { verify_room(opened()); });
  }
  std::string origin() const { return opened().distances_origin(); }
  std::string listed() const { return distances_text(room_); }

  // Estimated distances, constant at every other station of three lines, as `depth` leaves them.
  void estimate(float metres) const {
    fs::create_directories(distances_directory(room_, DistanceKind::kEstimated));
    const Room room = Room::open_rays(room_);
    Progress progress("writing", 1, "maps");
    for (const Line& line : room.grid().lines) {
      DistanceMaps maps{{}, kMapSize, "estimated by sweep", {}};
      if (line.id != "z1") maps.stations = {0, 6};
      maps.read = [&](std::size_t) {
        StationDistances distances{
            std::vector<float>(512, metres), std::vector<std::uint8_t>(512, 200), {}};
        distances.sha256 = checksum_of_distances(distances.distance_m, distances.confidence);
        return distances;
      };
      maps.left_out = {3, 1, 2, 4};
      write_distance_volume(volume(line.id, DistanceKind::kEstimated), line, maps, &progress);
    }
    use_distances(room_, DistanceKind::kEstimated);
  }

  const fs::path room_ = capture_.room();
};

TEST_F(DistanceSetsTest, ThosePackedWithTheRoomAreInUse) {
  EXPECT_EQ(origin(), "given");
  EXPECT_EQ(verify_room(opened()).distance_maps, kStations);
  EXPECT_THAT(listed(), AllOf(HasSubstr("views use the given distances"), HasSubstr("in use"),
                              HasSubstr("on 4 lines")));
}

TEST_F(DistanceSetsTest, AVolumeOfAnotherRoomIsRefused) {
  Line elsewhere = opened().grid().lines[3];
  for (Station& station : elsewhere.stations) station.position_m.y() += 0.01;
  const DistanceVolume own = opened().distances(3);
  Progress progress("writing", 1, "maps");
  write_distance_volume(volume("z1"), elsewhere,
                        {{own.stations().begin(), own.stations().end()},
                         own.size(),
                         kGivenOrigin,
                         [&](std::size_t i) { return stored_distances(own, static_cast<int>(i)); }},
                        &progress);
  EXPECT_THAT(open_error(), HasSubstr("given/z1.h5: holds the distances of another room"));
}

TEST_F(DistanceSetsTest, TruncatedVolumesAreRefused) {
  fs::resize_file(volume("z0"), fs::file_size(volume("z0")) - 1);
  EXPECT_THAT(open_error(), HasSubstr("given/z0.h5"));
}

// Bytes that hold nothing may differ.
TEST_F(DistanceSetsTest, VerifyFindsEveryFlippedByte) {
  estimate(2.0F);
  const fs::path file = volume("x1", DistanceKind::kEstimated);
  const Room intact = opened();
  const std::string bytes = read_file(file);
  int found = 0;
  for (std::size_t at = 5; at < bytes.size(); at += bytes.size() / 60) {
    std::string flipped = bytes;
    flipped[at] ^= 1;
    write_file_atomically(file, flipped);
    const std::string error = verify_error();
    if (error == "no error") {
      EXPECT_EQ(opened().distances(1).header_sha256(), intact.distances(1).header_sha256());
    } else {
      EXPECT_THAT(error, HasSubstr("x1")) << at;
      ++found;
    }
  }
  EXPECT_GT(found, 30);
  write_file_atomically(file, bytes);
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, AVolumeOfNoLineFailsVerify) {
  fs::copy_file(volume("x1"), volume("x7"));
  EXPECT_EQ(open_error(), "no error");
  EXPECT_THAT(verify_error(), HasSubstr("x7.h5: belongs to no line of the room"));
}

TEST_F(DistanceSetsTest, EstimatedDistancesComeInUseAndGivenOnesStay) {
  estimate(2.0F);
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_EQ(opened().distances(3).maps(), 0);
  EXPECT_THAT(listed(),
              AllOf(HasSubstr("views use the estimated distances"), HasSubstr("--use given")));
  const VerifiedCounts counts = verify_room(opened());
  EXPECT_EQ(counts.distance_maps, 6);
  EXPECT_EQ(counts.kept_distances, "given");
  estimate(3.0F);
  EXPECT_EQ(opened().distances(0).distance_column(0, 0)[0], 3.0F);
  EXPECT_EQ(verify_error(), "no error");
}

TEST_F(DistanceSetsTest, UseSwitchesThereAndBack) {
  estimate(2.0F);
  EXPECT_THAT(use_distances(room_, DistanceKind::kGiven), HasSubstr("now use the given"));
  EXPECT_EQ(origin(), "given");
  EXPECT_EQ(verify_room(opened()).kept_distances, "estimated by sweep");
  EXPECT_THAT(use_distances(room_, DistanceKind::kGiven), HasSubstr("already"));
  use_distances(room_, DistanceKind::kEstimated);
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_FALSE(fs::exists(room_ / "distances.lock"));
}

TEST_F(DistanceSetsTest, InfoNamesThoseInUseAndTheOthers) {
  estimate(2.0F);
  const RoomInfo info = info_of(opened());
  EXPECT_THAT(text_of(info, "room.lf"), AllOf(HasSubstr("distances in use: estimated by sweep"),
                                              HasSubstr("not in use: given")));
  const auto json = nlohmann::json::parse(json_of(info));
  EXPECT_EQ(json["distances"], "estimated by sweep");
  EXPECT_EQ(json["distance_sets"].size(), 2U);
  fs::remove(volume("z0"));
  EXPECT_THAT(text_of(info_of(opened()), "room.lf"),
              HasSubstr("not usable: " + volume("z0").string()));
}

TEST_F(DistanceSetsTest, ASetThatIsNotThereCannotBeUsed) {
  EXPECT_THAT(error_of([&] { use_distances(room_, DistanceKind::kEstimated); }),
              HasSubstr("raywalk-build-lf depth"));
  estimate(2.0F);
  fs::remove(volume("z0"));
  EXPECT_THAT(error_of([&] { use_distances(room_, DistanceKind::kGiven); }),
              HasSubstr("given/z0.h5: no such file"));
  EXPECT_THAT(verify_error(), HasSubstr("given/z0.h5"));
  EXPECT_EQ(origin(), "estimated by sweep");
  EXPECT_THROW(distance_kind_from_name("both"), UsageError);
}

TEST_F(DistanceSetsTest, OthersReplaceMissingOnes) {
  estimate(2.0F);
  fs::remove(volume("x0", DistanceKind::kEstimated));
  EXPECT_THAT(open_error(), HasSubstr("estimated/x0.h5: no such file"));
  use_distances(room_, DistanceKind::kGiven);
  EXPECT_EQ(origin(), "given");
}

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
    for (const StationIndex at : all_stations(a.grid())) {
      const TileReading reading;
      const auto rays = a.volume(at.line).columns(at.station);
      const auto others = b.volume(at.line).columns(at.station);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        largest = std::max(largest, std::abs(int{rays[i]} - int{others[i]}));
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
  std::string damaged = read_file(file);
  damaged.replace(damaged.size() / 2, 3, "\x55\xaa\x55");
  write_file_atomically(file, damaged);
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
