#include "tests/bench/hall_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "build_lf/pack/pack_room.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/room/room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kMapWidth = 64;
constexpr int kStationsPerMap = 2;

// Smooth, so that it is decoded quickly, with a different colour everywhere.
cv::Mat picture(int width) {
  cv::Mat image(width / 2, width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<cv::Vec3b>(v, u) = cv::Vec3b(
          cv::saturate_cast<uchar>(256 * u / width), cv::saturate_cast<uchar>(512 * v / width),
          cv::saturate_cast<uchar>(128 + 100 * std::sin(0.1 * u)));
    }
  }
  return image;
}

// Frames and maps are links to one file each.
build_lf::PackOptions make_capture(const Hall& hall, int width, const fs::path& capture) {
  const fs::path maps = capture / "distances";
  fs::create_directories(maps);
  write_image(capture / "picture.png", picture(width));
  write_image(capture / "map.png", cv::Mat(kMapWidth / 2, kMapWidth, CV_16UC1, cv::Scalar(3000)));
  std::vector<ListedFrame> listed;
  for (const StationPose& station : stations_of(hall)) {
    fs::create_hard_link(capture / "picture.png", capture / station.file);
    if (listed.size() % kStationsPerMap == 0) {
      fs::create_hard_link(capture / "map.png", maps / station.file);
    }
    listed.push_back({.file = station.file, .position_m = station.position_m});
  }
  write_file_atomically(capture / "poses.csv", frame_list_text(listed));
  build_lf::PackOptions options;
  options.frames = capture / "poses.csv";
  options.distances = maps;
  return options;
}

}  // namespace

Hall hall_of(int stations) {
  constexpr int kSteps = 50;
  // A cell has two sides of its own.
  const int cells = std::max(1, static_cast<int>(std::lround(std::sqrt(0.5 * stations / kSteps))));
  return {cells, cells, kSteps, 0};
}

std::vector<StationPose> stations_of(const Hall& hall) {
  std::vector<StationPose> stations;
  const auto add = [&](char axis, int line, int step, double x_m, double z_m) {
    stations.push_back(
        {fmt::format("{}{:03}_{:06}.png", axis, line, step + hall.overhang), {x_m, 0.0, z_m}, ""});
  };
  for (int line = 0; line <= hall.rows; ++line) {
    for (int i = -hall.overhang; i <= hall.columns * hall.steps + hall.overhang; ++i) {
      add('x', line, i, i / static_cast<double>(hall.steps), line);
    }
  }
  for (int line = 0; line <= hall.columns; ++line) {
    for (int i = -hall.overhang; i <= hall.rows * hall.steps + hall.overhang; ++i) {
      const bool crossing = i % hall.steps == 0 && i >= 0 && i <= hall.rows * hall.steps;
      if (!crossing) add('z', line, i, line, i / static_cast<double>(hall.steps));
    }
  }
  return stations;
}

fs::path hall_room(const Hall& hall, int width) {
  const fs::path folder = fs::path(RAYWALK_BENCH_DIR) / "halls";
  const fs::path room = folder / fmt::format("{}x{}_{}_steps_{}_overhang_{}_px.lf", hall.columns,
                                             hall.rows, hall.steps, hall.overhang, width);
  if (fs::exists(manifest_path(room))) return room;
  const fs::path capture = folder / "capture";
  fs::remove_all(capture);
  build_lf::PackOptions options = make_capture(hall, width, capture);
  options.out = room;
  build_lf::pack_room(options);
  fs::remove_all(capture);
  return room;
}

}  // namespace raywalk::bench
