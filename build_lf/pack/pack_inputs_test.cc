// What pack says of its inputs and of the disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/test_pack.h"
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
  EXPECT_THAT(testing::internal::GetCapturedStderr(), Not(HasSubstr("Corrupt")));
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
  std::ofstream list(capture_.list());
  list << "file,x,y,z\n";
  for (int i = 0; i < TestCapture::kStationsPerLine; ++i) {
    list << fmt::format("front_{}.png,{},0,0\n", i, 0.25 * i);
    list << fmt::format("back_{}.png,{},0,0.06\n", i, 0.25 * i + 0.1);
  }
  list.close();
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

}  // namespace
}  // namespace raywalk::build_lf
