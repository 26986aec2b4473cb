#include "capture/camera/mjpg_picture.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace raywalk::capture {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

// Noise uses every code of the tables.
cv::Mat noise(int width, int height) {
  cv::Mat picture(height, width, CV_8UC3);
  cv::RNG random(7);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

// libjpeg uses the standard tables unless it optimizes them.
std::string jpeg_of(const cv::Mat& picture, int optimise = 0) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes,
               {cv::IMWRITE_JPEG_QUALITY, 98, cv::IMWRITE_JPEG_OPTIMIZE, optimise});
  return {bytes.begin(), bytes.end()};
}

struct Segment {
  std::size_t offset;
  std::size_t size;
};

std::vector<Segment> table_segments(const std::string& file) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(file.at(i)); };
  std::vector<Segment> segments;
  for (std::size_t i = 2; byte(i + 1) != 0xDA; i += 2 + 256U * byte(i + 2) + byte(i + 3)) {
    if (byte(i + 1) == 0xC4) segments.push_back({i, 2 + 256U * byte(i + 2) + byte(i + 3)});
  }
  return segments;
}

std::string without_tables(std::string file) {
  const std::vector<Segment> segments = table_segments(file);
  for (auto segment = segments.rbegin(); segment != segments.rend(); ++segment) {
    file.erase(segment->offset, segment->size);
  }
  return file;
}

// The tables' contents, whether they come in one segment or several.
std::string tables_of(const std::string& file) {
  std::string tables;
  for (const Segment& segment : table_segments(file)) {
    tables += file.substr(segment.offset + 4, segment.size - 4);
  }
  return tables;
}

cv::Mat decoded(const std::string& file) {
  return cv::imdecode(std::vector<unsigned char>(file.begin(), file.end()), cv::IMREAD_COLOR);
}

TEST(MjpgPicture, InsertsMissingStandardTables) {
  const std::string file = jpeg_of(noise(160, 80));
  const std::string frame = without_tables(file);
  ASSERT_LT(frame.size(), file.size());
  const std::optional<std::string> made = jpeg_from_mjpg(bytes_of(frame));
  ASSERT_TRUE(made);
  EXPECT_EQ(tables_of(*made), tables_of(file)) << "not the tables of T.81 annex K.3 as libjpeg has";
  EXPECT_EQ(cv::norm(decoded(*made), decoded(file), cv::NORM_INF), 0.0);
}

TEST(MjpgPicture, KeepsAFrameWithItsOwnTables) {
  const std::string file = jpeg_of(noise(32, 16), 1);
  EXPECT_EQ(jpeg_from_mjpg(bytes_of(file)), file);
}

TEST(MjpgPicture, SkipsFillBytesBeforeMarkers) {
  const std::string file = jpeg_of(noise(32, 16));
  std::string padded = file;
  padded.insert(2, "\xFF\xFF\xFF");
  EXPECT_EQ(jpeg_from_mjpg(bytes_of(padded)), padded);
  std::string bare = without_tables(file);
  bare.insert(2, "\xFF\xFF");
  const std::optional<std::string> made = jpeg_from_mjpg(bytes_of(bare));
  ASSERT_TRUE(made);
  EXPECT_EQ(cv::norm(decoded(*made), decoded(file), cv::NORM_INF), 0.0);
}

TEST(MjpgPicture, RefusesEveryPrefixWithoutAScan) {
  const std::string frame = without_tables(jpeg_of(noise(32, 16)));
  std::size_t scan = frame.find("\xFF\xDA");
  for (std::size_t size = 0; size < scan; ++size) {
    EXPECT_FALSE(jpeg_from_mjpg(bytes_of(frame.substr(0, size)))) << size;
  }
  EXPECT_FALSE(jpeg_from_mjpg(bytes_of(std::string(100, '\xFF'))));
  EXPECT_FALSE(jpeg_from_mjpg(bytes_of(std::string("\xFF\xD8\xFF\xE0\0\0\0\0\0\0", 10))));
  EXPECT_FALSE(jpeg_from_mjpg(bytes_of("<html>no camera here</html>")));
}

}  // namespace
}  // namespace raywalk::capture
