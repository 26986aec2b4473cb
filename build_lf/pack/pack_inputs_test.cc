// What pack says of its inputs and of the disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_capture.h"
#include "core/base/test_error.h"
#include "core/base/test_log.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

class PackInputsTest : public ::testing::Test {
 protected:
  std::string error() const {
    return error_of([&] { pack_room(options_); });
  }

  // Leaves two of the four lines finished, as a stopped run does, and a volume that was being
  // written.
  void stop_half_way() const {
    const std::string fingerprint = plan_pack(options_).fingerprint;
    pack_room(options_);
    fs::rename(capture_.room(), capture_.partial());
    for (const char* id : {"z0", "z1"}) fs::remove(line_volume_path(capture_.partial(), id));
    fs::remove(manifest_path(capture_.partial()));
    write_file_atomically(capture_.partial() / "inputs.sha256", fingerprint);
    std::ofstream(capture_.partial() / "lines" / ".z0.00000000-1.0.partial.h5") << "half";
  }

  TestCapture capture_;
  PackOptions options_ = [this] {
    PackOptions options;
    options.frames = capture_.list();
    options.out = capture_.room();
    return options;
  }();
};

// 28 panoramas of 64 x 32 pixels of 3 bytes.
constexpr std::uint64_t kRoomBytes = std::uint64_t{28} * 64 * 32 * 3;

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
  options_.free_bytes = [](const fs::path&) { return kRoomBytes - 1; };
  EXPECT_THAT(error(), AllOf(HasSubstr("needs 173 kB, 172 kB are free"), HasSubstr("room.lf")));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackInputsTest, StoppedRunNeedsSpaceOnlyForTheRest) {
  stop_half_way();
  options_.free_bytes = [](const fs::path&) { return kRoomBytes / 2 - 1; };
  EXPECT_THAT(error(), HasSubstr("needs 87 kB besides the 86 kB that are there, 86 kB are free"));
  EXPECT_TRUE(fs::exists(line_volume_path(capture_.partial(), "x0")));
  options_.free_bytes = [](const fs::path&) { return kRoomBytes / 2; };
  EXPECT_EQ(error(), "no error");
}

TEST_F(PackInputsTest, UnfinishedVolumesAreRemovedBeforeSpaceIsCounted) {
  stop_half_way();
  options_.free_bytes = [](const fs::path& room) {
    for (const auto& entry : fs::directory_iterator(room / "lines")) {
      EXPECT_FALSE(entry.path().filename().string().starts_with('.')) << entry.path();
    }
    return kRoomBytes;
  };
  EXPECT_EQ(error(), "no error");
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
  std::ofstream list(capture_.list());
  list << "file,x,y,z\n";
  for (int i = 0; i < 4; ++i) {
    cv::imwrite((capture_.root() / fmt::format("{}.jpg", i)).string(), picture);
    list << fmt::format("{}.jpg,{},0,0\n", i, 0.1 * i);
  }
  list.close();
  const fs::path damaged = capture_.root() / "2.jpg";
  const std::string whole = read_file(damaged);
  write_file_atomically(damaged, whole.substr(0, whole.size() / 2) + "\xFF\xD9");
  testing::internal::CaptureStderr();
  EXPECT_THAT(error(), HasSubstr("2.jpg: the image is damaged or cut short"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), Not(HasSubstr("Corrupt")));
  EXPECT_FALSE(fs::exists(capture_.partial()));
}

TEST_F(PackInputsTest, MillimetresAreWarnedOf) {
  std::ofstream list(capture_.list());
  list << "file,x,y,z\n";
  for (const auto& row : capture_.rows()) {
    list << fmt::format("{},{},0,{}\n", row.file, 1e3 * row.x_m, 1e3 * row.z_m);
  }
  list.close();
  const CapturedLog log;
  pack_room(options_);
  EXPECT_THAT(log.text(), AllOf(HasSubstr(capture_.list().string()), HasSubstr("millimetres"),
                                HasSubstr("1000 m wide")));
}

// Two passes 60 mm apart are two lines within the default tolerance, one with the tolerance that
// the warning proposes.
TEST_F(PackInputsTest, PassesSideBySideAreWarnedOf) {
  std::ofstream list(capture_.list());
  list << "file,x,y,z\n";
  for (int i = 0; i < TestCapture::kStationsPerLine; ++i) {
    list << fmt::format("front_{}.png,{},0,0\n", i, 0.25 * i);
    list << fmt::format("back_{}.png,{},0,0.06\n", i, 0.25 * i + 0.1);
  }
  list.close();
  {
    const CapturedLog log;
    pack_room(options_);
    EXPECT_THAT(log.text(),
                AllOf(HasSubstr("x0 and x1 are 60 mm apart"), HasSubstr("--line-tolerance-mm 60")));
  }
  options_.replace = true;
  options_.tolerance.off_line_m = 0.06;
  const CapturedLog log;
  pack_room(options_);
  EXPECT_THAT(log.text(), IsEmpty());
}

TEST_F(PackInputsTest, ExifOrientationIsWarnedOf) {
  // An EXIF segment whose orientation is 3.
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0"
      "MM\0\x2A\0\0\0\x08"
      "\0\x01\x01\x12\0\x03\0\0\0\x01\0\x03\0\0\0\0\0\0",
      36);
  std::ofstream list(capture_.list());
  list << "file,x,y,z\n";
  for (int i = 0; i < 3; ++i) {
    const fs::path file = capture_.root() / fmt::format("{}.jpg", i);
    cv::imwrite(file.string(), cv::Mat(32, 64, CV_8UC3, cv::Scalar::all(90)));
    const std::string jpeg = read_file(file);
    if (i > 0) write_file_atomically(file, jpeg.substr(0, 2) + exif + jpeg.substr(2));
    list << fmt::format("{}.jpg,{},0,0\n", i, 0.1 * i);
  }
  list.close();
  const CapturedLog log;
  pack_room(options_);
  EXPECT_THAT(log.text(), AllOf(HasSubstr("1.jpg: its EXIF orientation 3"), HasSubstr("1 more")));
}

TEST_F(PackInputsTest, AStatedAttitudeThatTheListLacksIsWarnedOf) {
  for (const char* yaw : {"0", "5"}) {
    std::ofstream list(capture_.list());
    list << "file,x,y,z,yaw\n";
    for (int i = 0; i < 3; ++i) {
      const fs::path file = capture_.root() / fmt::format("{}.jpg", i);
      cv::imwrite(file.string(), cv::Mat(32, 64, CV_8UC3, cv::Scalar::all(90)));
      const std::string tags = "<x GPano:PosePitchDegrees=\"23\"/>";
      if (i > 0) write_file_atomically(file, with_app1(read_file(file), "http://ns\n", tags));
      list << fmt::format("{}.jpg,{},0,0,{}\n", i, 0.1 * i, yaw);
    }
    list.close();
    const CapturedLog log;
    plan_pack(options_);
    const std::string warned = log.text();
    EXPECT_EQ(warned.find("1.jpg: states a pitch of 23.0") != std::string::npos, yaw[0] == '0');
    EXPECT_EQ(warned.find("2 of 3 frames") != std::string::npos, yaw[0] == '0');
  }
}

TEST_F(PackInputsTest, NothingIsWarnedOfInAnOrdinaryCapture) {
  const CapturedLog log;
  pack_room(options_);
  EXPECT_THAT(log.text(), IsEmpty());
}

}  // namespace
}  // namespace raywalk::build_lf
