#include "core/files/image_file.h"

#include <gmock/gmock.h>
#include <lcms2.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/colour_profile.h"
#include "core/files/exif.h"
#include "core/files/gpano.h"
#include "core/files/jpeg.h"
#include "core/files/test_support.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

cv::Mat noise(int width = 64, int height = 32, int type = CV_8UC3) {
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

  // Without the flush to disk of write_file_atomically, as hundreds of files are written.
  fs::path written(const std::string& name, const std::string& bytes) const {
    std::ofstream(directory_ / name, std::ios::binary) << bytes;
    return directory_ / name;
  }

  // The message of read_panorama; it names the file.
  static std::string panorama_error(const fs::path& file) {
    std::string error = error_of([&] { read_panorama(file); });
    EXPECT_THAT(error, HasSubstr(file.string()));
    return error;
  }

  TestDirectory directory_;
};

TEST_F(ImageFileTest, PngRoundTripIsExactAndJpegKeepsSizeAndColourOrder) {
  const cv::Mat orange(32, 64, CV_8UC3, cv::Scalar(200, 100, 20));
  const fs::path png = written("a.png", noise()), jpeg = written("a.JPG", orange);
  EXPECT_EQ(cv::norm(read_panorama(png), noise(), cv::NORM_INF), 0.0);
  EXPECT_LE(cv::norm(read_panorama(jpeg), orange, cv::NORM_INF), 3.0);
  for (const fs::path& file : {png, jpeg}) {
    EXPECT_EQ(panorama_header_of(file).size, (PanoramaSize{64, 32}));
  }
  EXPECT_EQ(read_panorama(written("grey.png", noise(8, 4, CV_8UC1))).type(), CV_8UC3);
}

TEST_F(ImageFileTest, ExifOrientationIsIgnored) {
  const std::string jpeg = read_file(written("a.jpg", noise()));
  const std::string block = exif_block({short_entry(EXIF_TAG_ORIENTATION, 6)}, {});
  const fs::path turned = written("turned.jpg", with_app1(jpeg, kExifIdentifier, block));
  ASSERT_EQ(cv::imread(turned.string(), cv::IMREAD_COLOR).cols, 32) << "the test's EXIF is wrong";
  EXPECT_EQ(read_panorama(turned).cols, 64);
}

TEST_F(ImageFileTest, SizeIsFoundBehindALongHeader) {
  const std::string jpeg = read_file(written("a.jpg", noise()));
  std::string previews;
  for (int i = 0; i < 10; ++i) previews += "\xFF\xE2\xFF\xFF" + std::string(65533, 'p');
  const fs::path file = written("b.jpg", jpeg.substr(0, 2) + previews + jpeg.substr(2));
  EXPECT_EQ(panorama_header_of(file).size, (PanoramaSize{64, 32}));
}

// libpng would print what it finds.
TEST_F(ImageFileTest, DamagedAndTruncatedPngsAreErrorsAndPrintNothing) {
  const std::string whole = read_file(written("a.png", noise(16, 8, CV_8UC3)));
  testing::internal::CaptureStderr();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    panorama_error(written("a.png", bytes));
    if (at == 0) continue;
    EXPECT_THAT(panorama_error(written("a.png", whole.substr(0, at))), HasSubstr("cut short"));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
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
  const std::string jpeg = read_file(written("f.jpg", noise()));
  const std::string tags =
      "<x GPano:FullPanoHeightPixels=\"64\" GPano:CroppedAreaImageHeightPixels=\"32\"/>";
  EXPECT_THAT(panorama_error(written("g.jpg", with_app1(jpeg, "http://ns.adobe.com/", tags))),
              HasSubstr("part of the sphere"));
}

TEST_F(ImageFileTest, MasksAreBlackOrNotAndAlphaIsOne) {
  const cv::Mat levels = (cv::Mat_<uchar>(1, 4) << 0, 127, 128, 255), ones = levels / 255;
  const auto mask_of = [&](const cv::Mat& picture) {
    const cv::Mat mask = read_mask(written("m.png", picture), {4, 1});
    return std::vector<int>(mask.begin<uchar>(), mask.end<uchar>());
  };
  EXPECT_THAT(mask_of(levels), ElementsAre(0, 0, 255, 255));
  EXPECT_THAT(mask_of(levels >= 128), ElementsAre(0, 0, 255, 255));
  EXPECT_THAT(mask_of((levels >= 128) / 255), ElementsAre(0, 0, 255, 255)) << "0 and 1";
  EXPECT_THAT(mask_of(cv::Mat(1, 4, CV_8UC1, cv::Scalar(0))), ElementsAre(0, 0, 0, 0));
  const fs::path file = directory_ / "alpha.png";
  cv::Mat picture;
  cv::merge(std::vector<cv::Mat>{ones, ones, ones, levels}, picture);
  cv::imwrite(file.string(), picture);
  EXPECT_EQ(cv::norm(read_mask(file, {4, 1}), levels > 127, cv::NORM_INF), 0.0);
  EXPECT_THAT(error_of([&] { require_mask(file, {4, 1}); }), HasSubstr("8-bit grey"));
  EXPECT_TRUE(picture_header_of(file).has_alpha);
}

TEST_F(ImageFileTest, IntactImagesOfBothFormatsAreTold) {
  for (const std::string name : {"a.jpg", "a.png"}) {
    std::string bytes = read_file(written(name, noise()));
    EXPECT_EQ(require_intact_image(std::as_bytes(std::span(bytes)), name).size.width, 64);
    bytes.resize(bytes.size() - 5);
    EXPECT_THROW(require_intact_image(std::as_bytes(std::span(bytes)), name), Error);
  }
}

TEST_F(ImageFileTest, DistanceMapsRoundTripExactlyAndOtherImagesAreNone) {
  cv::Mat map(4, 8, CV_16UC1, cv::Scalar(65535));
  map.at<std::uint16_t>(0, 0) = 0;
  map.at<std::uint16_t>(3, 7) = 1234;
  EXPECT_EQ(cv::norm(read_distance_map(written("d.png", map)), map, cv::NORM_INF), 0.0);
  for (const auto& [name, type] :
       {std::pair("grey8.png", CV_8UC1), {"colour16.png", CV_16UC3}, {"photo.jpg", CV_8UC1}}) {
    const fs::path file = written(name, noise(8, 4, type));
    EXPECT_THAT(error_of([&] { read_distance_map(file); }),
                AllOf(HasSubstr(file.string()), HasSubstr("16-bit grey PNG")));
  }
}

TEST_F(ImageFileTest, WritingRejectsUnsupportedTypes) {
  EXPECT_THROW(write_image(directory_ / "a.bmp", noise()), UsageError);
  EXPECT_THROW(write_image(directory_ / "a", noise()), UsageError);
  EXPECT_THROW(write_image(directory_ / "a.png", cv::Mat()), Error);
  EXPECT_THROW(write_image(directory_ / "a.png", noise(8, 4, CV_32FC3)), Error);
  EXPECT_THROW(write_image(directory_ / "a.jpg", noise(8, 4, CV_16UC1)), Error);
  EXPECT_THROW(write_image(directory_ / "a.jpg", noise(70000, 2, CV_8UC3)), Error);
  EXPECT_THROW(write_image(directory_ / "missing/a.png", noise()), Error);
  EXPECT_EQ(directory_.entries(), 0U);
}

std::string encoded(const std::string& extension, int width, int height, int type,
                    const std::vector<int>& parameters = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, cv::Mat(height, width, type, cv::Scalar(30, 60, 90)), bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

ImageHeader header_of(const std::string& bytes) {
  return parse_image_header(std::as_bytes(std::span(bytes)), "a.jpg");
}

TEST(ImageHeader, ReadsWhatTheEncoderWrote) {
  for (const int progressive : {0, 1}) {
    const ImageHeader jpeg =
        header_of(encoded(".jpg", 300, 150, CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
    EXPECT_EQ(jpeg.format, ImageFormat::kJpeg);
    EXPECT_EQ(jpeg.size, (PanoramaSize{300, 150}));
    EXPECT_EQ(jpeg.bits_per_channel, 8);
    EXPECT_FALSE(jpeg.is_grey);
    EXPECT_EQ(jpeg.orientation, 1);
  }
  EXPECT_TRUE(header_of(encoded(".jpg", 8, 4, CV_8UC1)).is_grey);
  const ImageHeader png = header_of(encoded(".png", 70000, 2, CV_16UC1));
  EXPECT_EQ(png.format, ImageFormat::kPng);
  EXPECT_EQ(png.size, (PanoramaSize{70000, 2}));
  EXPECT_EQ(png.bits_per_channel, 16);
  EXPECT_TRUE(png.is_grey);
  EXPECT_FALSE(header_of(encoded(".png", 4, 2, CV_8UC3)).is_grey);
}

// The first directory of a TIFF block of either byte order has the orientation as second entry.
std::string block_with(char orientation, bool little_endian) {
  if (little_endian) {
    return exif_block({ascii_entry(EXIF_TAG_MAKE, "a"),
                       short_entry(EXIF_TAG_ORIENTATION, static_cast<std::uint16_t>(orientation))},
                      {});
  }
  std::string block(
      "MM\0*\0\0\0\x08\0\x02\x01\x0F\0\x02\0\0\0\x01\0\0\0\0\x01\x12\0\x03\0\0\0\x01\0?"
      "\0\0\0\0\0\0",
      38);
  return block.replace(block.find('?'), 1, 1, orientation);
}

std::string jpeg_with(const std::string& block) {
  return with_app1(encoded(".jpg", 64, 32, CV_8UC3), kExifIdentifier, block);
}

std::string png_with(const std::string& block) {
  std::string png = encoded(".png", 64, 32, CV_8UC3);
  const std::string size(1, static_cast<char>(block.size()));
  // Behind IHDR; the checksum is not read.
  return png.insert(33, std::string(3, '\0') + size + "eXIf" + block + std::string(4, '\0'));
}

TEST(ImageHeader, OrientationIsReadFromExif) {
  for (const bool little_endian : {false, true}) {
    for (char orientation = 1; orientation <= 8; ++orientation) {
      const std::string block = block_with(orientation, little_endian);
      EXPECT_EQ(header_of(jpeg_with(block)).orientation, orientation);
      EXPECT_EQ(header_of(png_with(block)).orientation, orientation);
    }
  }
}

TEST(ImageHeader, DamagedExifIsUpright) {
  const std::string whole = block_with(6, true);
  for (std::size_t length = 0; length < 22; ++length) {
    EXPECT_EQ(header_of(jpeg_with(whole.substr(0, length))).orientation, 1) << length;
  }
  for (const char bad : {char{0}, char{9}, static_cast<char>(255)}) {
    EXPECT_EQ(header_of(jpeg_with(block_with(bad, true))).orientation, 1);
  }
  std::string beyond = whole;
  beyond[4] = beyond[7] = static_cast<char>(0xFF);  // the directory's offset
  EXPECT_EQ(header_of(jpeg_with(beyond)).orientation, 1);
}

TEST(ImageHeader, NonImagesAreRejected) {
  using namespace std::string_literals;
  EXPECT_THROW(header_of(encoded(".bmp", 4, 2, CV_8UC3)), Error);
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xD9"), Error) << "ends before it has a size";
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xC0\0\4\10\0"s), Error) << "frame header too short";
  EXPECT_THROW(header_of("\xFF\xD8\xFF\xC0\0\x0B\x08\0\0\0\4\1\1\x11\0"s), Error) << "height 0";
  std::string huge = encoded(".png", 4, 2, CV_8UC3);
  EXPECT_THROW(header_of(huge.replace(16, 4, "\xFF\xFF\xFF\xFE")), Error);
}

std::string bytes_of_profile(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  return bytes;
}

// Adobe RGB (1998), 4.3.1: white, primaries and gamma.
std::string adobe_rgb() {
  const cmsCIExyY white{0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1.0}, {0.21, 0.71, 1.0}, {0.15, 0.06, 1.0}};
  cmsToneCurve* gamma = cmsBuildGamma(nullptr, 563.0 / 256.0);
  const std::array<cmsToneCurve*, 3> curves{gamma, gamma, gamma};
  std::string bytes = bytes_of_profile(cmsCreateRGBProfile(&white, &primaries, curves.data()));
  cmsFreeToneCurve(gamma);
  return bytes;
}

// The same colour by the definitions of both spaces: linear by the gamma, the matrices of Adobe RGB
// (1998), 4.3.5.3 and IEC 61966-2-1, and sRGB's curve.
cv::Vec3b srgb_of_adobe(const cv::Vec3b& bgr) {
  const cv::Matx33d xyz_from_adobe(0.57667, 0.18556, 0.18823, 0.29734, 0.62736, 0.07529, 0.02703,
                                   0.07069, 0.99134);
  const cv::Matx33d srgb_from_xyz(3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557,
                                  -0.2040, 1.0570);
  const auto linear = [](uchar level) { return std::pow(level / 255.0, 563.0 / 256.0); };
  const cv::Vec3d rgb =
      srgb_from_xyz * (xyz_from_adobe * cv::Vec3d(linear(bgr[2]), linear(bgr[1]), linear(bgr[0])));
  const auto level = [](double value) {
    const double x = std::clamp(value, 0.0, 1.0);
    const double curved = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return cv::saturate_cast<uchar>(255.0 * curved);
  };
  return {level(rgb[2]), level(rgb[1]), level(rgb[0])};
}

std::string png_with_profile(const std::string& profile) {
  std::string packed(compressBound(profile.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size,
           reinterpret_cast<const Bytef*>(profile.data()), profile.size());
  packed.resize(size);
  const std::string data = std::string("iCCPname\0\0", 10) + packed;
  const auto big_endian = [](std::size_t value) {
    std::string bytes;
    for (int i = 3; i >= 0; --i) bytes.push_back(static_cast<char>(value >> (8 * i)));
    return bytes;
  };
  const std::string chunk =
      big_endian(data.size() - 4) + data +
      big_endian(crc32_z(0, reinterpret_cast<const Bytef*>(data.data()), data.size()));
  const auto png = encode_image("a.png", noise());
  return std::string(png.begin(), png.end()).insert(33, chunk);  // behind IHDR
}

// In two pieces, the second one first.
std::string jpeg_with_profile(const std::string& profile) {
  const auto segment = [&](char number, const std::string& piece) {
    const std::size_t length = 2 + 14 + piece.size();
    return std::string("\xFF\xE2") + static_cast<char>(length >> 8) +
           static_cast<char>(length & 0xFF) + std::string("ICC_PROFILE\0", 12) + number + '\2' +
           piece;
  };
  const auto jpeg = encode_jpeg(noise(), 100);
  std::string bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  return bytes.insert(2,
                      segment('\2', profile.substr(200)) + segment('\1', profile.substr(0, 200)));
}

TEST_F(ImageFileTest, APictureInAnotherColourSpaceIsReadAsSrgb) {
  const auto jpeg = encode_jpeg(noise(), 100);
  for (const bool is_jpeg : {false, true}) {
    const fs::path file = is_jpeg ? written("a.jpg", jpeg_with_profile(adobe_rgb()))
                                  : written("a.png", png_with_profile(adobe_rgb()));
    const cv::Mat stored = is_jpeg ? decode_jpeg(jpeg, CV_8UC3, "plain") : noise();
    const cv::Mat read = read_panorama(file);
    double largest = 0.0, changed = 0.0;
    for (int i = 0; i < static_cast<int>(stored.total()); ++i) {
      const cv::Vec3b expected = srgb_of_adobe(stored.at<cv::Vec3b>(i));
      largest = std::max(largest, cv::norm(read.at<cv::Vec3b>(i), expected, cv::NORM_INF));
      changed = std::max(changed, cv::norm(stored.at<cv::Vec3b>(i), expected, cv::NORM_INF));
    }
    EXPECT_GT(changed, 30.0) << "the test's colours are too pale";
    EXPECT_LE(largest, 2.0) << is_jpeg;
  }
}

TEST(ColourProfile, SrgbDamagedAndOtherProfilesChangeNothing) {
  cmsToneCurve* gamma = cmsBuildGamma(nullptr, 1.8);
  const std::string grey = bytes_of_profile(cmsCreateGrayProfile(cmsD50_xyY(), gamma));
  cmsFreeToneCurve(gamma);
  const std::string srgb = bytes_of_profile(cmsCreate_sRGBProfile()), adobe = adobe_rgb();
  for (const std::string& profile :
       {std::string(), srgb, grey, adobe.substr(0, 100), std::string(500, 'x')}) {
    cv::Mat picture = noise();
    convert_to_srgb(profile, &picture);
    EXPECT_EQ(cv::norm(picture, noise(), cv::NORM_INF), 0.0) << profile.size();
  }
}

TEST(ColourProfile, CutAndDamagedFilesHaveAProfileOrNone) {
  for (const std::string& whole : {jpeg_with_profile(adobe_rgb()), png_with_profile(adobe_rgb())}) {
    EXPECT_EQ(embedded_profile(std::as_bytes(std::span(whole))), adobe_rgb());
    const std::size_t end = std::min<std::size_t>(whole.size(), 1000);
    for (std::size_t at = 2; at < end; ++at) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
      embedded_profile(std::as_bytes(std::span(bytes)));
      embedded_profile(std::as_bytes(std::span(whole).first(at)));
    }
  }
}

TEST(Gpano, TheStatedAttitudeIsReadFromBothFormsOfXmp) {
  const auto attitude = [](const std::string& xmp) {
    return stated_attitude(std::as_bytes(std::span(xmp)));
  };
  const auto attributes =
      attitude(R"(<rdf GPano:PosePitchDegrees="-23.5" GPano:PoseRollDegrees="2"/>)");
  EXPECT_EQ(attributes.value().pitch_deg, -23.5);
  EXPECT_EQ(attributes->roll_deg, 2.0);
  EXPECT_EQ(attitude("<GPano:PoseRollDegrees>11</GPano:PoseRollDegrees>").value().roll_deg, 11.0);
  EXPECT_FALSE(attitude("GPano:PosePitchDegrees=\"level\""));
  EXPECT_FALSE(attitude("JFIF"));
}

TEST(Gpano, APartOfAPanoramaIsTold) {
  const auto is_cropped = [](const std::string& xmp) {
    return is_stated_as_cropped(std::as_bytes(std::span(xmp)));
  };
  const std::string whole =
      R"(GPano:FullPanoWidthPixels="4096" GPano:FullPanoHeightPixels="2048" )";
  EXPECT_FALSE(is_cropped(whole));
  EXPECT_FALSE(is_cropped(whole + R"(GPano:CroppedAreaImageWidthPixels="4096")"));
  EXPECT_TRUE(is_cropped(whole + R"(GPano:CroppedAreaImageWidthPixels="4095")"));
  EXPECT_TRUE(is_cropped(whole + "<GPano:CroppedAreaImageHeightPixels>900<"));
}

}  // namespace
}  // namespace raywalk
