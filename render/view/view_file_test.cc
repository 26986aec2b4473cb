#include "render/view/view_file.h"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/files/image_file.h"
#include "core/files/test_support.h"
#include "core/view/test_room.h"
#include "render/view/point_argument.h"
#include "render/view/write_picture.h"

namespace raywalk::render {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;
namespace fs = std::filesystem;

TEST(ViewFrame, IsAPanoramaUnlessItHasAFieldOfView) {
  EXPECT_FALSE(viewport_of({}));
  EXPECT_FALSE(viewport_of({.yaw_deg = 30.0}));
  const auto viewport = viewport_of({.yaw_deg = 30.0, .pitch_deg = -5.0, .fov_deg = 90.0});
  ASSERT_TRUE(viewport);
  EXPECT_DOUBLE_EQ(viewport->attitude.yaw_rad, radians_from_degrees(30.0));
  EXPECT_DOUBLE_EQ(viewport->attitude.pitch_rad, radians_from_degrees(-5.0));
  EXPECT_DOUBLE_EQ(viewport->fov_x_rad, kHalfPi);
  EXPECT_EQ(viewport->width, 1280);
  EXPECT_EQ(viewport->height, 720);
  EXPECT_EQ(viewport_of({.fov_deg = 60.0, .size = "1440x1600"})->height, 1600);
}

TEST(ViewFrame, RejectsMalformedSizes) {
  for (const char* size : {"1440", "x", "1440x", "x20", "1440x1600x3", "axb", "4.5x2"}) {
    EXPECT_THAT([&] { viewport_of({.fov_deg = 90.0, .size = size}); },
                ThrowsMessage<UsageError>(HasSubstr("WIDTHxHEIGHT")))
        << size;
  }
  EXPECT_THAT([] { viewport_of({.fov_deg = 90.0, .size = "-4x100"}); },
              ThrowsMessage<UsageError>(HasSubstr("1 to 16384")));
  EXPECT_THAT([] { viewport_of({.size = "100x100"}); },
              ThrowsMessage<UsageError>(HasSubstr("--fov-deg")));
  EXPECT_THROW(viewport_of({.yaw_deg = std::nan("")}), UsageError);
}

TEST(ViewFrame, TwoEyesSeePanoramasThatAreTurnedInThePlanOnly) {
  EXPECT_FALSE(viewport_of({.yaw_deg = 30.0, .stereo = Stereo::kOds, .ipd_mm = 200.0}));
  EXPECT_EQ(ipd_mm_of({.stereo = Stereo::kOds}), 63.0);
  for (const ViewFrame& frame :
       {ViewFrame{.fov_deg = 90.0, .stereo = Stereo::kOds},
        ViewFrame{.pitch_deg = 1.0, .stereo = Stereo::kOds},
        ViewFrame{.roll_deg = 1.0, .stereo = Stereo::kOds},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = 0.9},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = 201.0},
        ViewFrame{.stereo = Stereo::kOds, .ipd_mm = std::nan("")}, ViewFrame{.ipd_mm = 63.0}}) {
    EXPECT_THROW(viewport_of(frame), UsageError);
  }
}

class WriteView : public testing::Test {
 protected:
  cv::Mat written(const ViewFrame& frame) {
    told_ = write_view(room_.room(), {.options = {.k_deg = 76.0}, .k_source = "given"}, {0.1, -0.2},
                       frame, directory_ / "view.png");
    return read_picture(directory_ / "view.png");
  }
  TestDirectory directory_;
  TestRoom room_{box_room(128)};
  std::string told_;
};

TEST_F(WriteView, TurnsAPanorama) {
  const cv::Mat straight = written({});
  ASSERT_EQ(straight.size(), cv::Size(128, 64));
  // A quarter to the right: what was a quarter right of the middle is in the middle.
  const cv::Mat turned = written({.yaw_deg = 90.0});
  for (int u = 0; u < 96; ++u) {
    EXPECT_LE(cv::norm(turned.col(u), straight.col(u + 32), cv::NORM_INF), 1.0);
  }
  // Upside down.
  const cv::Mat over = written({.roll_deg = 180.0});
  cv::Mat flipped;
  cv::flip(straight, flipped, -1);
  EXPECT_LE(cv::norm(over, flipped, cv::NORM_INF), 1.0);
}

TEST_F(WriteView, ReplacesViewsButNothingElse) {
  written({});
  EXPECT_NO_THROW(written({.fov_deg = 80.0, .size = "32x32"}));
  EXPECT_NO_THROW(written({}));
  write_image(directory_ / "view.png", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_THAT([&] { written({}); }, ThrowsMessage<Error>(HasSubstr("is no view made by Raywalk")));
  EXPECT_EQ(read_picture(directory_ / "view.png").size(), cv::Size(8, 8));
}

TEST_F(WriteView, TurnsThePanoramasOfBothEyes) {
  const cv::Mat straight = written({.stereo = Stereo::kOds});
  ASSERT_EQ(straight.size(), cv::Size(128, 128));
  EXPECT_GT(cv::norm(straight.rowRange(0, 64), straight.rowRange(64, 128), cv::NORM_INF), 1.0);
  const cv::Mat turned = written({.yaw_deg = 90.0, .stereo = Stereo::kOds});
  for (int u = 0; u < 96; ++u) {
    EXPECT_LE(cv::norm(turned.col(u), straight.col(u + 32), cv::NORM_INF), 1.0);
  }
}

TEST_F(WriteView, WritesAFlatPictureInItsDirection) {
  const cv::Mat straight = written({});
  const cv::Mat picture = written({.yaw_deg = -90.0, .fov_deg = 40.0, .size = "65x33"});
  EXPECT_EQ(picture.size(), cv::Size(65, 33));
  EXPECT_THAT(told_, HasSubstr("65x33, enlarged 4.4 times from panoramas 128 pixels wide, at 0.1"));
  written({.fov_deg = 120.0, .size = "32x32"});
  EXPECT_THAT(told_, Not(HasSubstr("enlarged")));
  const cv::Vec3b middle = picture.at<cv::Vec3b>(16, 32);
  const cv::Vec3b left = straight.at<cv::Vec3b>(32, 32);
  EXPECT_LE(cv::norm(cv::Vec3d(middle) - cv::Vec3d(left)), 12.0);
}

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

using Words = std::vector<std::string>;

TEST(PointTest, NumbersHaveACommaSpacesOrBothBetweenThem) {
  for (const char* text :
       {"-0.1,0.25", "-0.1, 0.25", "-0.1 0.25", " -0.1  ,  0.25 ", "-.1\t+.25"}) {
    EXPECT_THAT(parse_point(text), ElementsAre(-0.1, 0.25)) << text;
  }
  for (const char* text : {"1,2,3", "1 2 3", "1, 2 ,3", " 1  2\t3 ", "1,2 3", "1 ,2 ,3"}) {
    EXPECT_THAT(parse_point(text), ElementsAre(1.0, 2.0, 3.0)) << text;
  }
}

TEST(PointTest, HasTwoOrThreeFiniteNumbersAndNothingElse) {
  for (const char* text : {"", " ", "1", "1,", ",1", "1;2", "x,1", "1,nan", "inf 0", "1e999,0",
                           "1,2,3,4", "1 2 3 4", "0,1 0,2", "1,,2", "1,2,", ",1,2", "1,2,x"}) {
    EXPECT_TRUE(parse_point(text).empty()) << text;
  }
}

class JoinedPointsTest : public testing::Test {
 protected:
  JoinedPointsTest() {
    CLI::App* view = app_.add_subcommand("view");
    add_point_option(view, "--at", &at_, "where");
    view->add_option("--yaw-deg", yaw_deg_);
    add_point_option(view, "--eye", &eye_, "where", PointKind::kPlanOrSpace);
  }
  Words joined(Words words) const { return joined_points(app_, std::move(words)); }

  CLI::App app_{"", "raywalk-test"};
  std::string at_, eye_;
  double yaw_deg_ = 0.0;
};

TEST_F(JoinedPointsTest, WordsOfOnePointBecomeOne) {
  EXPECT_THAT(joined({"view", "--at", "0", "0", "room.lf"}),
              ElementsAre("view", "--at", "0 0", "room.lf"));
  EXPECT_THAT(joined({"view", "--at", "-0.1", "-0.2"}), ElementsAre("view", "--at", "-0.1 -0.2"));
  EXPECT_THAT(joined({"view", "--at", "0,", "0"}), ElementsAre("view", "--at", "0, 0"));
  EXPECT_THAT(joined({"view", "--at", "0", ",0"}), ElementsAre("view", "--at", "0 ,0"));
  EXPECT_THAT(joined({"view", "--at", "0", ",", "0"}), ElementsAre("view", "--at", "0 , 0"));
  EXPECT_THAT(joined({"view", "--at=0", "-1", "x"}), ElementsAre("view", "--at=0 -1", "x"));
}

TEST_F(JoinedPointsTest, APointOfSpaceHasUpToThreeNumbers) {
  EXPECT_THAT(joined({"view", "--eye", "0", "1", "-2", "room.lf"}),
              ElementsAre("view", "--eye", "0 1 -2", "room.lf"));
  EXPECT_THAT(joined({"view", "--eye", "0", ",", "1", ",", "2"}),
              ElementsAre("view", "--eye", "0 , 1 , 2"));
  EXPECT_THAT(joined({"view", "--eye=0,1", "room.lf"}),
              ElementsAre("view", "--eye=0,1", "room.lf"));
}

TEST_F(JoinedPointsTest, OtherWordsStayAsTheyAre) {
  for (const Words& words : {Words{"view", "--at", "0,0", "7"}, Words{"view", "--at=-0.1,0.2", "7"},
                             Words{"view", "--at", "0", "--yaw-deg", "3"}, Words{"view", "--at"},
                             Words{"view", "--at", "0"}, Words{"view", "--yaw-deg", "3", "4"}}) {
    EXPECT_EQ(joined(words), words);
  }
}

}  // namespace
}  // namespace raywalk::render
