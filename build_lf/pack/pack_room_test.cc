#include "build_lf/pack/pack_room.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "build_lf/pack/listed_motion.h"
#include "build_lf/pack/test_pack.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/files/frame_list.h"
#include "core/files/output_folder.h"
#include "core/files/test_support.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
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
  for (const StationIndex station : all_stations(room.grid())) {
    const int frame = frame_of(room.grid().station(station));
    for (const auto [u, v] : pixels_of({TestCapture::kWidth, TestCapture::kHeight})) {
      const auto column = room.volume(station.line).column(station.station, u);
      const cv::Vec3b packed(column[3 * v], column[3 * v + 1], column[3 * v + 2]);
      ASSERT_EQ(packed, TestCapture::colour(frame, u, v));
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
      const int frame = frame_of(room.grid().station({line, volume.stations()[map]}));
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
    EXPECT_EQ(room.volume(0).column(2, world_u)[3 * v], TestCapture::colour(frame, camera_u, v)[0]);
    EXPECT_FLOAT_EQ(room.distances(0).distance_column(2, world_u)[v],
                    static_cast<float>(TestCapture::distance_mm(frame, camera_u, v)) * 1e-3F);
  }
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

MakeFault map_of_size(int frame, cv::Size size) {
  return [=](const TestCapture& capture) { capture.write_distance_map(frame, size); };
}
void mix_frame_sizes(const TestCapture& capture) { capture.write_frame(9, {32, 16}); }
void mix_map_sizes(const TestCapture& capture) {
  capture.write_distance_map(0, {32, 16});
  capture.write_distance_map(1, {64, 32});
}
void map_colours(const TestCapture& capture) {
  cv::imwrite((capture.distances() / "front_0.png").string(), cv::Mat(16, 32, CV_8UC3));
}
void map_of_no_frame(const TestCapture& capture) {
  fs::rename(capture.path(3), capture.distances() / "of_no_frame.png");
  capture.write_frame(3, {64, 32});
}
void remove_maps(const TestCapture& capture) { fs::remove_all(capture.distances()); }
void map_as_text(const TestCapture& capture) {
  std::ofstream(capture.distances() / "front_0.png") << "text";
}

INSTANTIATE_TEST_SUITE_P(
    All, CaptureFaultTest,
    ::testing::ValuesIn(std::vector<CaptureFault>{
        {"MixedSizes", mix_frame_sizes, {"back_2.png is 32 x 16", "front_0.png is 64 x 32"}},
        {"LargerMap", map_of_size(0, {128, 64}), {"front_0.png", "larger than the frames"}},
        {"MapsOfTwoSizes", mix_map_sizes, {"must have one size"}},
        {"MapNotTwoToOne", map_of_size(1, {32, 20}), {"front_1.png", "2:1"}},
        {"MapOfColours", map_colours, {"dist/front_0.png", "16-bit"}},
        {"MapOfText", map_as_text, {"dist/front_0.png"}},
        {"MapsOfNoFrame", map_of_no_frame, {"no map is named after a frame", "front_0.png"}},
        {"NoMaps", remove_maps, {"no such directory"}},
    }),
    [](const auto& fault) { return std::string(fault.param.name); });

TEST_F(PackRoomTest, ATruncatedMapIsNamed) {
  give_maps({27});
  const fs::path map = capture_.distances() / "right_6.png";
  fs::resize_file(map, fs::file_size(map) - 20);
  EXPECT_THAT(error(), HasSubstr("dist/right_6.png"));
  EXPECT_FALSE(fs::exists(capture_.room()));
}

TEST_F(PackRoomTest, OutMayEndInASlash) {
  options_.out = capture_.room() / "";
  pack();
  EXPECT_TRUE(fs::exists(manifest_path(capture_.room())));
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
  EXPECT_EQ(front.distance_maps, 1);
  for (const double quarter_m : {front.spacing_min_m, front.spacing_max_m,
                                 front.overhang_first_m.value(), front.overhang_last_m.value()}) {
    EXPECT_NEAR(quarter_m, 0.25, 1e-12);
  }
  EXPECT_THAT(text_of(info, "room.lf"), HasSubstr("4 lines, 1 cell, 28 panoramas of 64 x 32"));
  EXPECT_EQ(info.bytes, bytes_in(capture_.room()));
}

TEST_F(PackRoomTest, SingleLineHasNoOverhang) {
  std::ofstream(capture_.list()) << "file,x,y,z\nfront_0.png,0,0,0\nfront_1.png,0.1,0,0\n";
  const RoomInfo info = info_of(pack());
  EXPECT_TRUE(info.cells.empty());
  EXPECT_FALSE(info.lines[0].overhang_first_m.has_value());
  EXPECT_THAT(text_of(info, "room.lf"), HasSubstr("no cell is closed"));
  EXPECT_THAT(json_of(info), HasSubstr("\"overhang_first_m\": null"));
}

// What pack says of its inputs and of the disk.
class PackInputsTest : public PackTest {
 protected:
  std::string log_of_pack() const {
    const CapturedLog log;
    pack_room(options_);
    return log.text();
  }
};

TEST_F(PackInputsTest, AFrameThatIsNoPanoramaIsNamed) {
  for (int frame = 0; frame < TestCapture::kStations; ++frame) {
    capture_.write_frame(frame, {256, 128});
  }
  cv::Mat fisheyes(128, 256, CV_8UC3, cv::Scalar::all(0));
  for (const int centre : {64, 192}) {
    cv::circle(fisheyes, {centre, 64}, 62, cv::Scalar(90, 150, 210), cv::FILLED);
  }
  cv::imwrite((capture_.list().parent_path() / "back_3.png").string(), fisheyes);
  EXPECT_THAT(error(), AllOf(HasSubstr("back_3.png"), HasSubstr("two fisheye lenses")));
  EXPECT_FALSE(fs::exists(capture_.room()));
}

TEST_F(PackInputsTest, FullDiskIsRefusedBeforeAnythingIsWritten) {
  options_.free_bytes = [](const fs::path&) { return TestCapture::kRayBytes - 1; };
  EXPECT_THAT(error(), AllOf(HasSubstr("needs 173 kB, 172 kB are free"), HasSubstr("room.lf")));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackInputsTest, ExistingRoomAndMissingFilesAreReportedBeforeLinesAreSought) {
  capture_.write_list("off.png,3.1,0,2.9\n");  // a station of no line, and no such file
  EXPECT_THAT(error(), HasSubstr("off.png: no such file"));
  fs::create_directory(capture_.room());
  EXPECT_THAT(error(), HasSubstr("exists already"));
}

TEST_F(PackInputsTest, SpecialFilesAreRefusedInsteadOfWaitedFor) {
  for (const fs::path& file : {capture_.path(3), capture_.list()}) {
    const fs::path kept = file.string() + ".kept";
    fs::rename(file, kept);
    ASSERT_EQ(mkfifo(file.c_str(), 0666), 0);
    EXPECT_THAT(error(), AllOf(HasSubstr(file.string()), HasSubstr("named pipe")));
    fs::remove(file);
    fs::create_directory(file);
    EXPECT_THAT(error(), AllOf(HasSubstr(file.string()), HasSubstr("directory")));
    fs::remove(file);
    fs::rename(kept, file);
  }
}

TEST_F(PackInputsTest, SpecialFilesAsMasksAndDistanceMapsAreRefused) {
  std::ofstream(capture_.list()) << "file,x,y,z,mask,line\nfront_0.png,0,0,0,mask.png,a\n"
                                    "front_1.png,0.1,0,0,mask.png,a\n";
  ASSERT_EQ(mkfifo((capture_.root() / "mask.png").c_str(), 0666), 0);
  EXPECT_THAT(error(), AllOf(HasSubstr("mask.png"), HasSubstr("named pipe")));
  capture_.write_list();
  options_.distances = capture_.distances();
  fs::create_directory(capture_.distances());
  ASSERT_EQ(mkfifo((capture_.distances() / "front_0.png").c_str(), 0666), 0);
  EXPECT_THAT(error(), AllOf(HasSubstr("dist/front_0.png"), HasSubstr("named pipe")));
}

TEST_F(PackInputsTest, DamagedJpegIsNamedAndNothingIsKept) {
  cv::Mat picture(32, 64, CV_8UC3);
  cv::randu(picture, 0, 255);
  capture_.write_jpeg_line(4);
  const fs::path damaged = capture_.jpeg(2);
  cv::imwrite(damaged.string(), picture);
  const std::string whole = read_file(damaged);
  write_file_atomically(damaged, whole.substr(0, whole.size() / 2) + "\xFF\xD9");
  testing::internal::CaptureStderr();
  EXPECT_THAT(error(), HasSubstr("2.jpg: the image is damaged or cut short"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), ::testing::Not(HasSubstr("Corrupt")));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackInputsTest, MillimetresAreWarnedOf) {
  capture_.write_rows("file,x,y,z", [](const TestCapture::Row& row) {
    return fmt::format("{},{},0,{}", row.file, 1e3 * row.x_m, 1e3 * row.z_m);
  });
  EXPECT_THAT(log_of_pack(), AllOf(HasSubstr(capture_.list().string()), HasSubstr("millimetres"),
                                   HasSubstr("1000 m wide")));
}

// Two passes 60 mm apart are two lines within the default tolerance, one with the tolerance that
// the warning proposes.
TEST_F(PackInputsTest, PassesSideBySideAreWarnedOf) {
  std::string list = "file,x,y,z\n";
  for (int i = 0; i < TestCapture::kStationsPerLine; ++i) {
    list += fmt::format("front_{}.png,{},0,0\n", i, 0.25 * i);
    list += fmt::format("back_{}.png,{},0,0.06\n", i, 0.25 * i + 0.1);
  }
  write_file_atomically(capture_.list(), list);
  EXPECT_THAT(log_of_pack(),
              AllOf(HasSubstr("x0 and x1 are 60 mm apart"), HasSubstr("--line-tolerance-mm 60")));
  options_.replace = true;
  options_.tolerance.off_line_m = 0.06;
  EXPECT_THAT(log_of_pack(), IsEmpty());
}

TEST_F(PackInputsTest, ExifOrientationIsWarnedOf) {
  // An EXIF segment whose orientation is 3.
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0"
      "MM\0\x2A\0\0\0\x08"
      "\0\x01\x01\x12\0\x03\0\0\0\x01\0\x03\0\0\0\0\0\0",
      36);
  capture_.write_jpeg_line(3);
  for (const int i : {1, 2}) {
    const std::string jpeg = read_file(capture_.jpeg(i));
    write_file_atomically(capture_.jpeg(i), jpeg.substr(0, 2) + exif + jpeg.substr(2));
  }
  EXPECT_THAT(log_of_pack(),
              AllOf(HasSubstr("1.jpg: its EXIF orientation 3"), HasSubstr("1 more")));
}

TEST_F(PackInputsTest, AStatedAttitudeThatTheListLacksIsWarnedOf) {
  for (const std::string yaw : {"0", "5"}) {
    capture_.write_jpeg_line(3, ",yaw", "," + yaw);
    for (const int i : {1, 2}) {
      const std::string tags = "<x GPano:PosePitchDegrees=\"23\"/>";
      write_file_atomically(capture_.jpeg(i),
                            with_app1(read_file(capture_.jpeg(i)), "http://ns\n", tags));
    }
    const CapturedLog log;
    plan_pack(options_);
    const std::string warned = log.text();
    EXPECT_EQ(warned.find("1.jpg: states a pitch of 23.0") != std::string::npos, yaw == "0");
    EXPECT_EQ(warned.find("2 of 3 frames") != std::string::npos, yaw == "0");
  }
}

TEST_F(PackInputsTest, NothingIsWarnedOfInAnOrdinaryCapture) {
  EXPECT_THAT(log_of_pack(), IsEmpty());
}

// What is said of the photographed room with rows of its list changed.
template <typename Change>
std::string fault_of_list(const Change& change) {
  const TestDirectory directory;
  std::vector<ListedFrame> rows;
  for (const Frame& frame : read_frame_list(fs::path(RAYWALK_TEST_ROOM) / "poses.csv")) {
    rows.push_back({.file = frame.path.string(), .position_m = frame.position_m});
    change(&rows.back());
  }
  write_file_atomically(directory / "poses.csv", frame_list_text(rows));
  const PackPlan plan =
      plan_pack({.frames = directory / "poses.csv", .out = directory / "room.lf"});
  return error_of([&] { require_listed_motion(plan, "poses.csv"); });
}

// The same with every position changed.
std::string fault_of(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& moved) {
  return fault_of_list([&](ListedFrame* row) { row->position_m = moved(row->position_m); });
}

using Position = const Eigen::Vector3d&;

TEST(ListedMotionTest, RightListsPassAndWrongAxesAreNamed) {
  EXPECT_EQ(fault_of([](Position at) { return at; }), "no error");
  EXPECT_THAT(fault_of([](Position at) { return Eigen::Vector3d(at.x(), 0.0, -at.z()); }),
              AllOf(HasSubstr("what is listed along z moves along -z"),
                    HasSubstr("z grows the other way in the list")));
  EXPECT_THAT(fault_of([](Position at) { return Eigen::Vector3d(-at.x(), 0.0, at.z()); }),
              HasSubstr("mirrored"));
  EXPECT_THAT(fault_of([](Position at) { return Eigen::Vector3d(-at); }), HasSubstr("backwards"));
  EXPECT_THAT(fault_of([](Position at) { return Eigen::Vector3d(at.z(), 0.0, -at.x()); }),
              HasSubstr("turned by 90 degrees"));
  EXPECT_THAT(fault_of([](Position at) { return Eigen::Vector3d(at.z(), 0.0, at.x()); }),
              HasSubstr("x and z are exchanged"));
}

TEST(ListedMotionTest, ALineInReverseOrderIsNamed) {
  const auto reverse_back = [](ListedFrame* row) {
    if (row->file.find("back_") != std::string::npos) row->position_m.x() *= -1;
  };
  EXPECT_THAT(fault_of_list(reverse_back),
              AllOf(HasSubstr("line x0"), HasSubstr("back_"), HasSubstr("reverse order")));
}

// Turned pictures with their attitudes are as good as upright ones.
TEST(ListedMotionTest, AttitudesAreHonoured) {
  const auto turned = [](double yaw_rad) {
    return [=](ListedFrame* row) { row->attitude = {.yaw_rad = yaw_rad}; };
  };
  EXPECT_EQ(fault_of_list(turned(0.0)), "no error");
  EXPECT_THAT(fault_of_list(turned(kPi)), HasSubstr("backwards"));
}

TEST(CostsOfTravel, EqualAndUnrelatedPicturesSayNothing) {
  cv::Mat noise(128, 256, CV_8UC3), other = noise.clone();
  cv::randu(noise, 0, 255);
  cv::randu(other, 0, 255);
  for (const double cost : costs_of_travel(noise, noise)) EXPECT_EQ(cost, 1.0);
  const cv::Mat plain(128, 256, CV_8UC3, cv::Scalar::all(40));
  for (const double cost : costs_of_travel(plain, plain)) EXPECT_EQ(cost, 1.0);
  const DirectionCosts costs = costs_of_travel(noise, other);
  const auto [least, most] = std::ranges::minmax(costs);
  EXPECT_GT(least, 0.8 * most);  // none is clearly better than another
}

}  // namespace
}  // namespace raywalk::build_lf
