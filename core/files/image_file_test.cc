#include "core/files/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/test_log.h"
#include "core/files/atomic_output.h"
#include "core/files/exif.h"
#include "core/files/test_directory.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

cv::Mat noise(int width, int height, int type) {
  cv::Mat picture(height, width, type);
  cv::theRNG().state = 5;
  cv::randu(picture, cv::Scalar::all(0), cv::Scalar::all(255));
  return picture;
}

class ImageFileTest : public testing::Test {
 protected:
  fs::path written(const std::string& name, const cv::Mat& picture) const {
    write_image(directory_ / name, picture);
    return directory_ / name;
  }

  fs::path written(const std::string& name, const std::string& bytes) const {
    write_file_atomically(directory_ / name, bytes);
    return directory_ / name;
  }

  // The message of read_panorama; it names the file.
  static std::string panorama_error(const fs::path& file) {
    try {
      read_panorama(file);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr(file.string()));
      return e.what();
    }
    return "";
  }

  TestDirectory directory_;
};

TEST_F(ImageFileTest, PngRoundTripIsExact) {
  const cv::Mat picture = noise(64, 32, CV_8UC3);
  const fs::path file = written("a.png", picture);
  EXPECT_EQ(cv::norm(read_panorama(file), picture, cv::NORM_INF), 0.0);
  EXPECT_EQ(panorama_size_of(file), (PanoramaSize{64, 32}));
}

TEST_F(ImageFileTest, JpegRoundTripKeepsSizeAndColourOrder) {
  const fs::path file = written("a.JPG", cv::Mat(32, 64, CV_8UC3, cv::Scalar(200, 100, 20)));
  const cv::Mat read = read_panorama(file);
  EXPECT_EQ(read.size(), cv::Size(64, 32));
  EXPECT_LE(cv::norm(read, cv::Mat(32, 64, CV_8UC3, cv::Scalar(200, 100, 20)), cv::NORM_INF), 3.0);
  EXPECT_EQ(panorama_size_of(file), (PanoramaSize{64, 32}));
}

TEST_F(ImageFileTest, GreyPanoramaBecomesColour) {
  EXPECT_EQ(read_panorama(written("a.png", noise(8, 4, CV_8UC1))).type(), CV_8UC3);
}

TEST_F(ImageFileTest, ExifOrientationIsIgnored) {
  const std::string jpeg = read_file(written("a.jpg", noise(64, 32, CV_8UC3)));
  const std::string block = exif_block({short_entry(EXIF_TAG_ORIENTATION, 6)}, {});
  const fs::path turned = written("turned.jpg", with_app1(jpeg, kExifIdentifier, block));
  ASSERT_EQ(cv::imread(turned.string(), cv::IMREAD_COLOR).cols, 32) << "the test's EXIF is wrong";
  EXPECT_EQ(read_panorama(turned).cols, 64);
}

TEST_F(ImageFileTest, SizeIsFoundBehindALongHeader) {
  const std::string jpeg = read_file(written("a.jpg", noise(64, 32, CV_8UC3)));
  std::string previews;
  for (int i = 0; i < 10; ++i) previews += "\xFF\xE2\xFF\xFF" + std::string(65533, 'p');
  EXPECT_EQ(panorama_size_of(written("b.jpg", jpeg.substr(0, 2) + previews + jpeg.substr(2))),
            (PanoramaSize{64, 32}));
}

TEST_F(ImageFileTest, TruncatedFilesAreErrors) {
  for (const std::string name : {"a.jpg", "a.png"}) {
    const std::string whole = read_file(written(name, noise(64, 32, CV_8UC3)));
    for (const double share : {0.001, 0.05, 0.3, 0.5, 0.9, 0.999}) {
      const auto length = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
      EXPECT_THAT(panorama_error(written(name, whole.substr(0, length + 1))),
                  HasSubstr("cut short"))
          << name << " " << share;
    }
  }
}

TEST_F(ImageFileTest, DamagedPngIsAnError) {
  std::string bytes = read_file(written("a.png", noise(64, 32, CV_8UC3)));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  EXPECT_THAT(panorama_error(written("a.png", bytes)), HasSubstr("damaged"));
}

TEST_F(ImageFileTest, NonPanoramasAreRejectedWithAReason) {
  EXPECT_THAT(panorama_error(directory_ / "none.jpg"), HasSubstr("No such file"));
  EXPECT_THAT(panorama_error(directory_.path()), HasSubstr("Is a directory"));
  EXPECT_THAT(panorama_error(written("a.jpg", std::string())), HasSubstr("empty"));
  EXPECT_THAT(panorama_error(written("b.jpg", "<html>404 not found</html>")),
              HasSubstr("JPEG or PNG is needed"));
  EXPECT_THAT(panorama_error(written("c.png", noise(1, 1, CV_8UC3))), HasSubstr("1x1"));
  EXPECT_THAT(panorama_error(written("d.jpg", noise(64, 33, CV_8UC3))), HasSubstr("64x33"));
  EXPECT_THAT(panorama_error(written("e.png", noise(8, 4, CV_16UC1))), HasSubstr("16 bits"));
}

TEST_F(ImageFileTest, SizeQueryRejectsInvalidHeaders) {
  EXPECT_THROW(panorama_size_of(directory_ / "none.jpg"), Error);
  EXPECT_THROW(panorama_size_of(written("b.jpg", std::string("<html>"))), Error);
  EXPECT_THROW(panorama_size_of(written("c.png", noise(1, 1, CV_8UC3))), Error);
  const std::string whole = read_file(written("d.jpg", noise(64, 32, CV_8UC3)));
  EXPECT_THROW(panorama_size_of(written("d.jpg", whole.substr(0, 30))), Error);
}

TEST_F(ImageFileTest, IntactImagesOfBothFormatsAreTold) {
  for (const std::string name : {"a.jpg", "a.png"}) {
    std::string bytes = read_file(written(name, noise(64, 32, CV_8UC3)));
    EXPECT_EQ(require_intact_image(std::as_bytes(std::span(bytes)), name).size.width, 64);
    bytes.resize(bytes.size() - 5);
    EXPECT_THROW(require_intact_image(std::as_bytes(std::span(bytes)), name), Error);
  }
}

TEST_F(ImageFileTest, OneWarningNamesTheFirstTurnedImageAndCountsTheOthers) {
  const CapturedLog log;
  TurnedPictures turned;
  turned.add("a.jpg", 1);
  turned.warn();
  EXPECT_EQ(log.text(), "");
  turned.add("b.jpg", 6);
  for (int i = 0; i < 3; ++i) turned.add("c.jpg", 3);
  turned.warn();
  EXPECT_THAT(log.text(), AllOf(HasSubstr("b.jpg"), HasSubstr("orientation 6"), HasSubstr("3 more"),
                                HasSubstr("used as they are stored")));
}

TEST_F(ImageFileTest, DistanceMapRoundTripIsExact) {
  cv::Mat map(4, 8, CV_16UC1, cv::Scalar(65535));
  map.at<std::uint16_t>(0, 0) = 0;
  map.at<std::uint16_t>(3, 7) = 1234;
  EXPECT_EQ(cv::norm(read_distance_map(written("d.png", map)), map, cv::NORM_INF), 0.0);
}

TEST_F(ImageFileTest, OtherImagesAreRejectedAsDistanceMaps) {
  for (const auto& [name, type] :
       {std::pair("grey8.png", CV_8UC1), {"colour16.png", CV_16UC3}, {"photo.jpg", CV_8UC1}}) {
    const fs::path file = written(name, noise(8, 4, type));
    try {
      read_distance_map(file);
      FAIL() << name;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), AllOf(HasSubstr(file.string()), HasSubstr("16-bit grey PNG")));
    }
  }
}

TEST_F(ImageFileTest, WritingRejectsUnsupportedTypes) {
  EXPECT_THROW(write_image(directory_ / "a.bmp", noise(8, 4, CV_8UC3)), UsageError);
  EXPECT_THROW(write_image(directory_ / "a", noise(8, 4, CV_8UC3)), UsageError);
  EXPECT_THROW(write_image(directory_ / "a.png", cv::Mat()), Error);
  EXPECT_THROW(write_image(directory_ / "a.png", noise(8, 4, CV_32FC3)), Error);
  EXPECT_THROW(write_image(directory_ / "a.jpg", noise(8, 4, CV_16UC1)), Error);
  EXPECT_THROW(write_image(directory_ / "a.jpg", noise(70000, 2, CV_8UC3)), Error);
  EXPECT_THROW(write_image(directory_ / "missing/a.png", noise(8, 4, CV_8UC3)), Error);
  EXPECT_EQ(directory_.entries(), 0U);
}

}  // namespace
}  // namespace raywalk
