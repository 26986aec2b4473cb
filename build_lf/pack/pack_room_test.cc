#include "build_lf/pack/pack_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "build_lf/pack/test_capture.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class PackRoomTest : public ::testing::Test {
 protected:
  void pack(bool with_distances = false) { pack_room(options(with_distances)); }
  PackOptions options(bool with_distances = false) const {
    PackOptions options;
    options.frames = capture_.list();
    options.out = capture_.room();
    if (with_distances) options.distances = capture_.distances();
    return options;
  }

  // The error of a pack run, which must leave neither a room nor a partial one.
  std::string clean_error(bool with_distances = false) {
    std::string message = "no error";
    try {
      pack(with_distances);
    } catch (const Error& error) {
      message = error.what();
    }
    EXPECT_FALSE(fs::exists(capture_.room()));
    EXPECT_FALSE(fs::exists(capture_.partial()));
    return message;
  }

  // The row of poses.csv a station came from.
  int frame_of(const Station& station) const {
    for (size_t i = 0; i < capture_.rows().size(); ++i) {
      if (capture_.rows()[i].file == station.file) return static_cast<int>(i);
    }
    ADD_FAILURE() << station.file;
    return 0;
  }

  TestCapture capture_;
};

TEST_F(PackRoomTest, EveryRayIsThePixelItCameFrom) {
  pack();
  const Room room = Room::open(capture_.room());
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
  for (int frame : {0, 3, 20}) capture_.write_distance_map(frame, {32, 16});
  cv::imwrite((capture_.distances() / "of_no_frame.png").string(), cv::Mat(9, 9, CV_16UC1));
  pack(true);
  const Room room = Room::open(capture_.room());
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
  std::ofstream list(capture_.list());
  list << "file,x,y,z,yaw\n";
  for (const auto& row : capture_.rows()) {
    list << fmt::format("{},{},0,{},90\n", row.file, row.x_m, row.z_m);
  }
  list.close();
  for (int frame = 0; frame < TestCapture::kStations; ++frame) {
    capture_.write_distance_map(frame, {TestCapture::kWidth, TestCapture::kHeight});
  }
  pack(true);
  const Room room = Room::open(capture_.room());
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

// Leaves a partial room as a stopped run does: one finished volume and a temporary file.
void stop_after_first_line(const TestCapture& capture) {
  fs::rename(capture.room(), capture.partial());
  for (const char* id : {"x1", "z0", "z1"}) fs::remove(line_volume_path(capture.partial(), id));
  fs::remove(manifest_path(capture.partial()));
  std::ofstream(capture.partial() / "lines" / ".x1.1.0.partial.h5") << "half";
}

TEST_F(PackRoomTest, StoppedRunIsResumedAndFinishedVolumesAreKept) {
  pack();
  stop_after_first_line(capture_);
  write_file_atomically(capture_.partial() / "inputs.sha256", plan_pack(options()).fingerprint);
  const auto written = fs::last_write_time(line_volume_path(capture_.partial(), "x0"));
  pack();
  EXPECT_EQ(fs::last_write_time(line_volume_path(capture_.room(), "x0")), written);
  EXPECT_EQ(verify_room(Room::open(capture_.room())).panoramas, TestCapture::kStations);
  EXPECT_FALSE(fs::exists(capture_.partial()));
  EXPECT_EQ(std::distance(fs::directory_iterator(capture_.room() / "lines"), {}), 4);
  EXPECT_FALSE(fs::exists(capture_.room() / "inputs.sha256"));
}

TEST_F(PackRoomTest, ResumingWithOtherInputsIsRejected) {
  pack();
  stop_after_first_line(capture_);
  write_file_atomically(capture_.partial() / "inputs.sha256", plan_pack(options()).fingerprint);
  capture_.write_frame(5, {TestCapture::kWidth, TestCapture::kHeight});
  try {
    pack();
    FAIL() << "was not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr(capture_.partial().string()), HasSubstr("remove it")));
  }
  EXPECT_TRUE(fs::exists(line_volume_path(capture_.partial(), "x0")));
}

TEST_F(PackRoomTest, FingerprintFollowsEveryInput) {
  capture_.write_distance_map(0, {32, 16});
  const std::string first = plan_pack(options()).fingerprint;
  EXPECT_EQ(plan_pack(options()).fingerprint, first);
  EXPECT_NE(plan_pack(options(true)).fingerprint, first);
  PackOptions smaller = options();
  smaller.form.kind = RayForm::Kind::kLossless;
  EXPECT_NE(plan_pack(smaller).fingerprint, first);
  capture_.write_list("# a note\n");
  EXPECT_EQ(plan_pack(options()).fingerprint, first);
}

TEST_F(PackRoomTest, MissingFrameIsNamedWithItsLine) {
  fs::remove(capture_.path(4));
  EXPECT_THAT(clean_error(), AllOf(HasSubstr("poses.csv:6"), HasSubstr("front_4.png")));
}

TEST_F(PackRoomTest, TruncatedFrameIsNamed) {
  for (int frame : {0, TestCapture::kStations - 1}) {
    fs::resize_file(capture_.path(frame), fs::file_size(capture_.path(frame)) / 2);
    EXPECT_THAT(clean_error(), HasSubstr(capture_.path(frame).filename().string()));
    capture_.write_frame(frame, {TestCapture::kWidth, TestCapture::kHeight});
  }
}

TEST_F(PackRoomTest, MixedSizesNameBothFrames) {
  capture_.write_frame(9, {32, 16});
  EXPECT_THAT(clean_error(),
              AllOf(HasSubstr("back_2.png is 32 x 16"), HasSubstr("front_0.png is 64 x 32")));
}

TEST_F(PackRoomTest, FrameThatIsNotTwoToOneIsNamed) {
  capture_.write_frame(0, {60, 32});
  EXPECT_THAT(clean_error(), HasSubstr("front_0.png"));
}

TEST_F(PackRoomTest, DistanceMapsOfTheWrongSizeAreNamed) {
  capture_.write_distance_map(0, {128, 64});
  EXPECT_THAT(clean_error(true),
              AllOf(HasSubstr("front_0.png"), HasSubstr("larger than the frames")));
  capture_.write_distance_map(0, {32, 16});
  capture_.write_distance_map(1, {64, 32});
  EXPECT_THAT(clean_error(true), HasSubstr("must have one size"));
  capture_.write_distance_map(1, {32, 20});
  EXPECT_THAT(clean_error(true), AllOf(HasSubstr("front_1.png"), HasSubstr("2:1")));
}

TEST_F(PackRoomTest, InvalidDistanceMapIsNamed) {
  fs::create_directories(capture_.distances());
  cv::imwrite((capture_.distances() / "front_0.png").string(), cv::Mat(16, 32, CV_8UC3));
  EXPECT_THAT(clean_error(true), AllOf(HasSubstr("dist/front_0.png"), HasSubstr("16-bit")));
  std::ofstream(capture_.distances() / "front_0.png") << "text";
  EXPECT_THAT(clean_error(true), HasSubstr("dist/front_0.png"));
}

TEST_F(PackRoomTest, DistancesThatMatchNoFrameAreAnError) {
  fs::create_directories(capture_.distances());
  EXPECT_THAT(clean_error(true), HasSubstr("front_0.png"));
  fs::remove_all(capture_.distances());
  EXPECT_THAT(clean_error(true), HasSubstr("no such directory"));
}

TEST_F(PackRoomTest, TruncatedDistanceMapIsNamedAndNothingIsKept) {
  capture_.write_distance_map(27, {64, 32});
  const fs::path map = capture_.distances() / "right_6.png";
  fs::resize_file(map, fs::file_size(map) - 20);
  EXPECT_THAT(clean_error(true), HasSubstr("dist/right_6.png"));
}

TEST_F(PackRoomTest, UnwritableOutputIsNamed) {
  PackOptions nowhere = options();
  nowhere.out = capture_.root() / "none" / "room.lf";
  try {
    pack_room(nowhere);
    FAIL() << "was not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("none/room.lf"));
  }
}

TEST_F(PackRoomTest, OutMayEndInASlash) {
  PackOptions slash = options();
  slash.out = capture_.room() / "";
  pack_room(slash);
  EXPECT_TRUE(fs::exists(manifest_path(capture_.room())));
}

TEST_F(PackRoomTest, VerifyFindsEveryKindOfDamage) {
  for (int frame = 0; frame < TestCapture::kStations; ++frame) {
    capture_.write_distance_map(frame, {32, 16});
  }
  pack(true);
  const VerifiedCounts counts = verify_room(Room::open(capture_.room()));
  EXPECT_EQ(counts.panoramas, TestCapture::kStations);
  EXPECT_EQ(counts.distance_maps, TestCapture::kStations);
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
    std::string message = "no error";
    try {
      verify_room(Room::open(capture_.room()));
    } catch (const Error& error) {
      message = error.what();
    }
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
  EXPECT_EQ(verify_room(Room::open(capture_.room())).panoramas, TestCapture::kStations);
}

TEST_F(PackRoomTest, VerifyDetectsAVolumeOfAnotherRoom) {
  pack();
  fs::copy_file(line_volume_path(capture_.room(), "x1"), line_volume_path(capture_.room(), "x0"),
                fs::copy_options::overwrite_existing);
  EXPECT_THROW(verify_room(Room::open(capture_.room())), Error);
}

TEST_F(PackRoomTest, InfoMeasuresLinesAndOverhang) {
  capture_.write_distance_map(1, {32, 16});
  pack(true);
  const RoomInfo info = info_of(Room::open(capture_.room()));
  EXPECT_EQ(info.stations, TestCapture::kStations);
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
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(capture_.room())) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  EXPECT_EQ(info.bytes, bytes);
}

TEST_F(PackRoomTest, SingleLineHasNoOverhang) {
  std::ofstream list(capture_.list());
  list << "file,x,y,z\nfront_0.png,0,0,0\nfront_1.png,0.1,0,0\n";
  list.close();
  pack();
  const RoomInfo info = info_of(Room::open(capture_.room()));
  EXPECT_TRUE(info.cells.empty());
  EXPECT_FALSE(info.lines[0].overhang_first_m.has_value());
  EXPECT_THAT(text_of(info, "room.lf"), HasSubstr("no cell is closed"));
  EXPECT_THAT(json_of(info), HasSubstr("\"overhang_first_m\": null"));
}

}  // namespace
}  // namespace raywalk::build_lf
