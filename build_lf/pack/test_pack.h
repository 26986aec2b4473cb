// For tests: a small capture on disk, and how it is packed.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "build_lf/pack/pack_room.h"
#include "core/files/test_support.h"
#include "core/geometry/test_pixels.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A square of side 1 m, seven stations per line (25 % overhang, a station of either line at every
// corner), 64 x 32 PNG frames whose pixel values encode frame and position.
class TestCapture {
 public:
  static constexpr int kStationsPerLine = 7;
  static constexpr int kStations = 4 * kStationsPerLine;
  static constexpr int kWidth = 64;
  static constexpr int kHeight = 32;
  static constexpr std::uint64_t kRayBytes = std::uint64_t{3} * kStations * kWidth * kHeight;

  // One row of poses.csv.
  struct Row {
    std::string file;
    double x_m, z_m;
  };

  TestCapture() {
    const std::vector<std::string> names = {"front", "back", "left", "right"};
    for (int i = 0; i < kStations; ++i) {
      const std::string& name = names[i / kStationsPerLine];
      const double along = -0.75 + 0.25 * (i % kStationsPerLine);
      const double place = name == "front" || name == "right" ? 0.5 : -0.5;
      const bool along_x = name == "front" || name == "back";
      rows_.push_back({fmt::format("{}_{}.png", name, i % kStationsPerLine),
                       along_x ? along : place, along_x ? place : along});
      write_frame(i, {kWidth, kHeight});
    }
    write_list();
  }

  // Red, green and blue of a frame's pixel.
  static cv::Vec3b colour(int frame, int u, int v) {
    return {static_cast<uchar>(3 * u + frame), static_cast<uchar>(7 * v + frame),
            static_cast<uchar>(u + 5 * v + 2 * frame)};
  }
  static int distance_mm(int frame, int u, int v) { return 1000 + 10 * frame + u + 100 * v; }

  void write_frame(int frame, cv::Size size) const {
    cv::Mat image(size, CV_8UC3);
    for (const auto [u, v] : pixels_of({size.width, size.height})) {
      const cv::Vec3b rgb = colour(frame, u, v);
      image.at<cv::Vec3b>(v, u) = {rgb[2], rgb[1], rgb[0]};
    }
    cv::imwrite(path(frame).string(), image);
  }

  // The pixel in the top left corner is sky.
  void write_distance_map(int frame, cv::Size size) const {
    std::filesystem::create_directories(distances());
    cv::Mat map(size, CV_16UC1);
    for (const auto [u, v] : pixels_of({size.width, size.height})) {
      map.at<ushort>(v, u) = static_cast<ushort>(distance_mm(frame, u, v));
    }
    map.at<ushort>(0, 0) = 0;
    cv::imwrite((distances() / path(frame).filename()).string(), map);
  }

  void write_list(const std::string& more = "") const {
    write_rows("file,x,y,z", [](const Row& row) {
      return fmt::format("{},{},0,{}", row.file, row.x_m, row.z_m);
    });
    std::ofstream(list(), std::ios::app) << more;
  }
  // A list of its own: what `text` returns of every frame.
  template <typename Text>
  void write_rows(const std::string& columns, const Text& text) const {
    std::ofstream stream(list());
    stream << columns << "\n";
    for (const Row& row : rows_) stream << text(row) << "\n";
  }
  // A list of one line of `count` JPEG pictures, 0.jpg to ..., in plain grey.
  void write_jpeg_line(int count, const std::string& columns = "", const std::string& values = "") {
    std::ofstream stream(list());
    stream << "file,x,y,z" << columns << "\n";
    for (int i = 0; i < count; ++i) {
      cv::imwrite(jpeg(i).string(), cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(90)));
      stream << fmt::format("{}.jpg,{},0,0{}\n", i, 0.1 * i, values);
    }
  }
  std::filesystem::path jpeg(int i) const { return root() / fmt::format("{}.jpg", i); }

  std::filesystem::path root() const { return directory_.path(); }
  std::filesystem::path list() const { return directory_ / "poses.csv"; }
  std::filesystem::path distances() const { return directory_ / "dist"; }
  std::filesystem::path room() const { return directory_ / "room.lf"; }
  std::filesystem::path partial() const { return directory_ / "room.lf.partial"; }
  std::filesystem::path path(int frame) const { return directory_ / rows_[frame].file; }
  const std::vector<Row>& rows() const { return rows_; }

 private:
  TestDirectory directory_;
  std::vector<Row> rows_;
};

class PackTest : public ::testing::Test {
 protected:
  static constexpr int kStations = TestCapture::kStations;

  Room pack() const {
    pack_room(options_);
    return Room::open(options_.out);
  }
  std::string error() const {
    return error_of([&] { pack_room(options_); });
  }
  // The error of a run that must leave neither a room nor a partial one.
  std::string clean_error() const {
    std::string message = error();
    EXPECT_FALSE(std::filesystem::exists(capture_.room())) << message;
    EXPECT_FALSE(std::filesystem::exists(capture_.partial())) << message;
    return message;
  }
  void give_maps(const std::vector<int>& frames) {
    for (const int frame : frames) capture_.write_distance_map(frame, {32, 16});
    options_.distances = capture_.distances();
  }
  void give_all_maps() {
    std::vector<int> all(kStations);
    std::iota(all.begin(), all.end(), 0);
    give_maps(all);
  }

  TestCapture capture_;
  PackOptions options_{.frames = capture_.list(), .out = capture_.room()};
};

}  // namespace raywalk::build_lf
