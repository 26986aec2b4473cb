#include "render/view/write_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

cv::Mat colours() {
  cv::Mat picture(32, 64, CV_8UC3);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u)
      picture.at<cv::Vec3b>(v, u) = cv::Vec3b(4 * u, 8 * v, 90);
  }
  return picture;
}

class WritePictureTest : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const ViewDescription& view,
                 std::optional<int> quality = {}) const {
    const fs::path file = directory_ / name;
    write_picture(file, colours(), picture_format(file, quality), view);
    return file;
  }
  // A property as text; "" where there is none.
  static std::string xmp(const fs::path& file, const std::string& name) {
    const std::string bytes = read_file(file), before = " " + name + "=\"";
    const std::size_t at = bytes.find(before);
    if (at == std::string::npos) return "";
    const std::size_t begin = at + before.size();
    return bytes.substr(begin, bytes.find('"', begin) - begin);
  }
  // A TIFF file is a block of tags itself, and WebP's chunk is one.
  static ExifTags exif(const fs::path& file) {
    std::string bytes = read_file(file);
    if (bytes.starts_with("RIFF")) bytes = bytes.substr(bytes.find("EXIF") + 8);
    if (bytes.starts_with("II")) bytes = with_app1("\xFF\xD8", kExifIdentifier, bytes);
    return ExifTags(std::as_bytes(std::span(bytes)));
  }
  TestDirectory directory_;
};

TEST_F(WritePictureTest, PanoramasSayThatTheyAreInEveryFormat) {
  const ViewDescription view{.x_m = -0.125,
                             .y_m = 1.5,
                             .z_m = 0.25,
                             .frame = {.yaw_deg = -30.0, .pitch_deg = 5.0, .roll_deg = 2.0}};
  for (const char* name : {"a.png", "a.jpg", "a.webp", "a.tif"}) {
    SCOPED_TRACE(name);
    const fs::path file = write(name, view);
    EXPECT_EQ(xmp(file, "GPano:ProjectionType"), "equirectangular");
    EXPECT_EQ(xmp(file, "GPano:FullPanoWidthPixels"), "64");
    EXPECT_EQ(xmp(file, "GPano:CroppedAreaImageHeightPixels"), "32");
    EXPECT_EQ(xmp(file, "GPano:CroppedAreaTopPixels"), "0");
    EXPECT_EQ(xmp(file, "GPano:PoseHeadingDegrees"), "330");
    EXPECT_EQ(xmp(file, "GPano:PosePitchDegrees"), "5");
    EXPECT_EQ(xmp(file, "GPano:PoseRollDegrees"), "2");
    EXPECT_EQ(xmp(file, "raywalk:X_m"), "-0.125");
    EXPECT_EQ(xmp(file, "raywalk:Y_m"), "1.5");
    EXPECT_EQ(xmp(file, "raywalk:Z_m"), "0.25");
    EXPECT_EQ(exif(file).text(EXIF_TAG_SOFTWARE), "Raywalk");
    EXPECT_FALSE(exif(file).number(EXIF_TAG_FOCAL_LENGTH));
    EXPECT_THAT(read_file(file), HasSubstr("http://ns.google.com/photos/1.0/panorama/"));
  }
  EXPECT_EQ(directory_.entries(), 4U);
}

TEST_F(WritePictureTest, APitchOverTheTopIsThatOfTheOtherSide) {
  const fs::path file = write("a.png", {.frame = {.yaw_deg = 10.0, .pitch_deg = 100.0}});
  EXPECT_EQ(xmp(file, "GPano:PoseHeadingDegrees"), "190");
  EXPECT_EQ(xmp(file, "GPano:PosePitchDegrees"), "80");
  EXPECT_EQ(std::abs(std::stod(xmp(file, "GPano:PoseRollDegrees"))), 180.0);
}

TEST_F(WritePictureTest, FlatPicturesSayTheirFocalLength) {
  for (const char* name : {"a.png", "a.jpg", "a.webp", "a.tif"}) {
    SCOPED_TRACE(name);
    const fs::path file = write(name, {.frame = {.fov_deg = 90.0}});
    EXPECT_EQ(exif(file).number(EXIF_TAG_FOCAL_LENGTH), 18.0);
    EXPECT_EQ(exif(file).number(EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM), 18.0);
    // 64 pixels on 3.6 cm.
    EXPECT_EQ(exif(file).number(EXIF_TAG_FOCAL_PLANE_X_RESOLUTION), 17.778);
    EXPECT_EQ(exif(file).number(EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT), 3.0);
    EXPECT_EQ(xmp(file, "GPano:ProjectionType"), "");
  }
  const fs::path far = write("far.jpg", {.frame = {.fov_deg = 1e-3}});
  EXPECT_FALSE(exif(far).number(EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM));
}

TEST_F(WritePictureTest, PanoramasForTwoEyesAreNotCalledOne) {
  const fs::path file = write("a.jpg", {.frame = {.stereo = Stereo::kOds, .ipd_mm = 60.0}});
  EXPECT_EQ(xmp(file, "raywalk:Stereo"), "top-bottom");
  EXPECT_EQ(xmp(file, "raywalk:EyesApart_mm"), "60");
  EXPECT_EQ(xmp(file, "GPano:ProjectionType"), "");
}

TEST_F(WritePictureTest, MetadataLeavesThePixelsAsTheyAre) {
  const cv::Mat picture = colours();
  const auto same = [&](const std::string& name, const cv::Mat& expected) {
    const cv::Mat read = cv::imread((directory_ / name).string(), cv::IMREAD_UNCHANGED);
    return read.type() == expected.type() && cv::norm(read, expected, cv::NORM_INF) == 0.0;
  };
  write("a.png", {});
  EXPECT_TRUE(same("a.png", picture));
  write("a.tif", {});
  EXPECT_TRUE(same("a.tif", picture));
  // JPEG without a quality is as it always was.
  write_image(directory_ / "plain.jpg", picture);
  write("c.jpg", {});
  EXPECT_TRUE(same("c.jpg", cv::imread((directory_ / "plain.jpg").string())));
}

TEST_F(WritePictureTest, QualityMakesSmallerFiles) {
  for (const char* name : {"a.jpg", "a.webp"}) {
    const auto usual = fs::file_size(write(name, {}));
    EXPECT_LT(fs::file_size(write(name, {}, 20)), usual) << name;
  }
}

TEST(PictureFormat, WrongCombinationsAreRefused) {
  const auto error = [](const char* file, std::optional<int> quality) {
    return error_of([&] { picture_format(file, quality); });
  };
  EXPECT_THAT(error("a.gif", {}), HasSubstr("end in .png, .jpg, .webp or .tif"));
  EXPECT_THAT(error("a", {}), HasSubstr("end in"));
  EXPECT_THAT(error("a.png", 90), HasSubstr("--quality is for .jpg and .webp"));
  EXPECT_EQ(picture_format("a.JPG", 90).extension, ".jpg");
}

}  // namespace
}  // namespace raywalk::render
