#include "build_lf/pack/pack_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "build_lf/pack/test_pack.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class PackRoomTest : public PackTest {
 protected:
  // The row of poses.csv a station came from.
  int frame_of(const Station& station) const {
    const auto& rows = capture_.rows();
    return static_cast<int>(std::ranges::find(rows, station.file, &TestCapture::Row::file) -
                            rows.begin());
  }
};

TEST_F(PackRoomTest, EveryRayIsThePixelItCameFrom) {
  const Room room = pack();
  ASSERT_EQ(room.grid().lines.size(), 4U);
  EXPECT_EQ(room.grid().cells.size(), 1U);
  EXPECT_FALSE(fs::exists(capture_.partial()));
  for (size_t line = 0; line < 4; ++line) {
    const std::vector<Station>& stations = room.grid().lines[line].stations;
    for (size_t s = 0; s < stations.size(); ++s) {
      const int frame = frame_of(stations[s]);
      for (int u = 0; u < TestCapture::kWidth; ++u) {
        const auto column = room.volume(static_cast<int>(line)).column(static_cast<int>(s), u);
        for (int v = 0; v < TestCapture::kHeight; ++v) {
          const cv::Vec3b rgb = TestCapture::colour(frame, u, v);
          const cv::Vec3b packed(column[3 * static_cast<size_t>(v)],
                                 column[3 * static_cast<size_t>(v) + 1],
                                 column[3 * static_cast<size_t>(v) + 2]);
          ASSERT_EQ(packed, rgb);
        }
      }
    }
  }
}

TEST_F(PackRoomTest, DistancesOfSomeStationsAreMetresAndSkyIsInfinitelyFar) {
  give_maps({0, 3, 20});
  cv::imwrite((capture_.distances() / "of_no_frame.png").string(), cv::Mat(9, 9, CV_16UC1));
  const Room room = pack();
  int maps = 0;
  for (int line = 0; line < 4; ++line) {
    const DistanceVolume& volume = room.distances(line);
    for (int map = 0; map < volume.maps(); ++map) {
      const auto station = static_cast<size_t>(volume.stations()[static_cast<size_t>(map)]);
      const int frame = frame_of(room.grid().lines[static_cast<size_t>(line)].stations[station]);
      EXPECT_EQ(volume.size(), (PanoramaSize{32, 16}));
      EXPECT_TRUE(std::isinf(volume.distance_column(map, 0)[0]));
      EXPECT_FLOAT_EQ(volume.distance_column(map, 7)[9],
                      static_cast<float>(TestCapture::distance_mm(frame, 7, 9)) * 1e-3F);
      EXPECT_EQ(volume.confidence_column(map, 31)[15], 255);
      ++maps;
    }
  }
  EXPECT_EQ(maps, 3);
}

TEST_F(PackRoomTest, YawTurnsPanoramaAndDistances) {
  capture_.write_rows("file,x,y,z,yaw", [](const TestCapture::Row& row) {
    return fmt::format("{},{},0,{},90", row.file, row.x_m, row.z_m);
  });
  for (int frame = 0; frame < kStations; ++frame) {
    capture_.write_distance_map(frame, {TestCapture::kWidth, TestCapture::kHeight});
  }
  options_.distances = capture_.distances();
  const Room room = pack();
  const int frame = frame_of(room.grid().lines[0].stations[2]);
  // World longitude theta shows camera longitude theta - 90 degrees: a quarter of the width less.
  const int world_u = 40, camera_u = world_u - TestCapture::kWidth / 4;
  for (int v = 0; v < TestCapture::kHeight; ++v) {
    const auto row = static_cast<size_t>(v);
    EXPECT_EQ(room.volume(0).column(2, world_u)[3 * row],
              TestCapture::colour(frame, camera_u, v)[0]);
    EXPECT_FLOAT_EQ(room.distances(0).distance_column(2, world_u)[row],
                    static_cast<float>(TestCapture::distance_mm(frame, camera_u, v)) * 1e-3F);
  }
}

TEST_F(PackRoomTest, ExistingRoomIsNotTouched) {
  pack();
  const std::string manifest = read_file(manifest_path(capture_.room()));
  EXPECT_THROW(pack(), Error);
  EXPECT_EQ(read_file(manifest_path(capture_.room())), manifest);
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

using MakeFault = std::function<void(const TestCapture&)>;

// What is wrong with the files of a capture, and what is said of it.
struct CaptureFault {
  const char* name;
  MakeFault make;
  std::vector<std::string> said;
};

class CaptureFaultTest : public PackTest, public ::testing::WithParamInterface<CaptureFault> {};

TEST_P(CaptureFaultTest, IsNamedAndNothingIsKept) {
  fs::create_directories(capture_.distances());
  GetParam().make(capture_);
  const bool is_of_frames = fs::exists(capture_.distances()) && fs::is_empty(capture_.distances());
  if (!is_of_frames) options_.distances = capture_.distances();
  const std::string error = clean_error();
  for (const std::string& part : GetParam().said) EXPECT_THAT(error, HasSubstr(part));
}

MakeFault frame_of_size(int frame, cv::Size size) {
  return [=](const TestCapture& capture) { capture.write_frame(frame, size); };
}
MakeFault map_of_size(int frame, cv::Size size) {
  return [=](const TestCapture& capture) { capture.write_distance_map(frame, size); };
}

INSTANTIATE_TEST_SUITE_P(
    All, CaptureFaultTest,
    ::testing::ValuesIn(std::vector<CaptureFault>{
        {"MissingFrame",
         [](const TestCapture& capture) { fs::remove(capture.path(4)); },
         {"poses.csv:6", "front_4.png"}},
        {"MixedSizes",
         frame_of_size(9, {32, 16}),
         {"back_2.png is 32 x 16", "front_0.png is 64 x 32"}},
        {"NotTwoToOne", frame_of_size(0, {60, 32}), {"front_0.png"}},
        {"LargerMap", map_of_size(0, {128, 64}), {"front_0.png", "larger than the frames"}},
        {"MapsOfTwoSizes",
         [](const TestCapture& capture) {
           capture.write_distance_map(0, {32, 16});
           capture.write_distance_map(1, {64, 32});
         },
         {"must have one size"}},
        {"MapNotTwoToOne", map_of_size(1, {32, 20}), {"front_1.png", "2:1"}},
        {"MapOfColours",
         [](const TestCapture& capture) {
           cv::imwrite((capture.distances() / "front_0.png").string(), cv::Mat(16, 32, CV_8UC3));
         },
         {"dist/front_0.png", "16-bit"}},
        {"MapOfText",
         [](const TestCapture& capture) {
           std::ofstream(capture.distances() / "front_0.png") << "text";
         },
         {"dist/front_0.png"}},
        {"MapsOfNoFrame",
         [](const TestCapture& capture) {
           fs::rename(capture.path(3), capture.distances() / "of_no_frame.png");
           capture.write_frame(3, {64, 32});
         },
         {"no map is named after a frame", "front_0.png"}},
        {"NoMaps",
         [](const TestCapture& capture) { fs::remove_all(capture.distances()); },
         {"no such directory"}},
    }),
    [](const auto& fault) { return std::string(fault.param.name); });

TEST_F(PackRoomTest, ATruncatedMapIsNamed) {
  give_maps({27});
  const fs::path map = capture_.distances() / "right_6.png";
  fs::resize_file(map, fs::file_size(map) - 20);
  EXPECT_THAT(error(), HasSubstr("dist/right_6.png"));
  EXPECT_FALSE(fs::exists(capture_.room()));
}

TEST_F(PackRoomTest, UnwritableOutputIsNamed) {
  options_.out = capture_.root() / "none" / "room.lf";
  EXPECT_THAT(error(), HasSubstr("none/room.lf"));
}

TEST_F(PackRoomTest, OutMayEndInASlash) {
  options_.out = capture_.room() / "";
  pack();
  EXPECT_TRUE(fs::exists(manifest_path(capture_.room())));
}

TEST_F(PackRoomTest, VerifyFindsEveryKindOfDamage) {
  give_all_maps();
  const VerifiedCounts counts = verify_room(pack());
  EXPECT_EQ(counts.panoramas, kStations);
  EXPECT_EQ(counts.distance_maps, kStations);
  const auto error_after_flipping = [&](const fs::path& file, const void* in_map, const void* base,
                                        std::uintmax_t base_offset) {
    const auto offset = static_cast<std::uintmax_t>(static_cast<const char*>(in_map) -
                                                    static_cast<const char*>(base)) +
                        base_offset;
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(offset));
    const char flipped = static_cast<char>(stream.get() ^ 1);
    stream.seekp(static_cast<std::streamoff>(offset));
    stream.put(flipped);
    stream.close();
    std::string message = error_of([&] { verify_room(Room::open(capture_.room())); });
    stream.open(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(offset));
    stream.put(static_cast<char>(flipped ^ 1));
    return message;
  };
  // Where the rays of station 0 begin in the file: their bytes are known.
  const fs::path lines = line_volume_path(capture_.room(), "z1");
  const Room room = Room::open(capture_.room());
  const auto first = room.volume(3).column(0, 0);
  const std::string bytes = read_file(lines);
  const std::size_t rays_at = bytes.find(std::string(first.begin(), first.end()));
  ASSERT_NE(rays_at, std::string::npos);
  EXPECT_THAT(
      error_after_flipping(lines, room.volume(3).column(5, 60).data(), first.data(), rays_at),
      AllOf(HasSubstr("line z1 station 5"), HasSubstr("right_5.png"), HasSubstr("rays"),
            HasSubstr("1 of 56")));
  const fs::path distances = distance_volume_path(capture_.room(), "x0");
  const auto confidence = room.distances(0).confidence_column(0, 0);
  const std::size_t confidence_at = read_file(distances).find(std::string(512, '\xff'));
  ASSERT_NE(confidence_at, std::string::npos);
  EXPECT_THAT(error_after_flipping(distances, confidence.data(), confidence.data(), confidence_at),
              AllOf(HasSubstr("line x0 station 0"), HasSubstr("distances")));
  EXPECT_EQ(verify_room(Room::open(capture_.room())).panoramas, kStations);
}

TEST_F(PackRoomTest, VerifyDetectsAVolumeOfAnotherRoom) {
  pack();
  fs::copy_file(line_volume_path(capture_.room(), "x1"), line_volume_path(capture_.room(), "x0"),
                fs::copy_options::overwrite_existing);
  EXPECT_THROW(verify_room(Room::open(capture_.room())), Error);
}

TEST_F(PackRoomTest, InfoMeasuresLinesAndOverhang) {
  give_maps({1});
  const RoomInfo info = info_of(pack());
  EXPECT_EQ(info.stations, kStations);
  EXPECT_EQ(info.distance_maps, 1);
  ASSERT_EQ(info.lines.size(), 4U);
  const LineInfo& front = info.lines[1];
  EXPECT_NEAR(front.place_m, 0.5, 1e-12);
  EXPECT_NEAR(front.from_m, -0.75, 1e-12);
  EXPECT_NEAR(front.to_m, 0.75, 1e-12);
  EXPECT_NEAR(front.spacing_min_m, 0.25, 1e-12);
  EXPECT_NEAR(front.spacing_max_m, 0.25, 1e-12);
  EXPECT_NEAR(front.overhang_first_m.value(), 0.25, 1e-12);
  EXPECT_NEAR(front.overhang_last_m.value(), 0.25, 1e-12);
  EXPECT_EQ(front.distance_maps, 1);
  EXPECT_THAT(text_of(info, "room.lf"), HasSubstr("4 lines, 1 cell, 28 panoramas of 64 x 32"));
  EXPECT_EQ(info.bytes, bytes_in(capture_.room()));
}

TEST_F(PackRoomTest, SingleLineHasNoOverhang) {
  std::ofstream list(capture_.list());
  list << "file,x,y,z\nfront_0.png,0,0,0\nfront_1.png,0.1,0,0\n";
  list.close();
  const RoomInfo info = info_of(pack());
  EXPECT_TRUE(info.cells.empty());
  EXPECT_FALSE(info.lines[0].overhang_first_m.has_value());
  EXPECT_THAT(text_of(info, "room.lf"), HasSubstr("no cell is closed"));
  EXPECT_THAT(json_of(info), HasSubstr("\"overhang_first_m\": null"));
}

}  // namespace
}  // namespace raywalk::build_lf
