#include "tests/bench/bench_room.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "build_lf/pack/derived_room.h"
#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/geometry/grid.h"
#include "core/room/room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

// The capture to enlarge; 16 stations per line are kept, 1.6 GB of rays.
struct SourceScene {
  fs::path directory;
  size_t station_step = 1;
  std::string name;  // of its directory in the cache
};

SourceScene source_scene() {
  const fs::path repository = RAYWALK_SOURCE_DIR;
  const fs::path full = repository.parent_path() / "shared/scenes/white-room";
  if (fs::exists(full / "poses.csv")) return {full, 4, "full-scene"};
  return {repository / "tests/data/white-room", 2, "embedded-scene"};
}

fs::path cache_of(const SourceScene& scene) { return fs::path(RAYWALK_BENCH_DIR) / scene.name; }

// Every `step`-th station of each line.
std::vector<Station> thinned_stations(const fs::path& list, size_t step) {
  std::vector<StationPose> poses;
  for (const Frame& frame : read_frame_list(list)) {
    poses.push_back({frame.file, frame.position_m, frame.where});
  }
  std::vector<Station> kept;
  for (const Line& line : find_grid(poses, {}).lines) {
    for (size_t i = 0; i < line.stations.size(); i += step) kept.push_back(line.stations[i]);
  }
  return kept;
}

std::string frame_name(const Station& station) {
  return fs::path(station.file).stem().string() + ".jpg";
}

void enlarge_frame(const fs::path& from, const fs::path& to) {
  cv::Mat frame;
  cv::resize(read_panorama(from), frame, {kBenchWidth, kBenchWidth / 2}, 0, 0, cv::INTER_CUBIC);
  if (!cv::imwrite(to.string(), frame, {cv::IMWRITE_JPEG_QUALITY, 95})) {
    throw Error(fmt::format("cannot write {}; check free space", to.string()));
  }
}

// The list is written last and marks the directory as complete.
void make_capture(const SourceScene& scene, const fs::path& capture) {
  fs::create_directories(capture);
  const auto stations = thinned_stations(scene.directory / "poses.csv", scene.station_step);
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Station& station = stations[static_cast<size_t>(i)];
      enlarge_frame(scene.directory / station.file, capture / frame_name(station));
    }
  });
  std::string list = "file,x,y,z\n";
  for (const Station& station : stations) {
    const Eigen::Vector3d& p = station.position_m;
    list += fmt::format("{},{},{},{}\n", frame_name(station), p.x(), p.y(), p.z());
  }
  write_file_atomically(capture / "poses.csv", list);
}

// False also for a room packed in another format version.
bool can_be_opened(const fs::path& room) {
  try {
    Room::open(room);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// With the descriptor of every file; `act` returns whether it succeeded.
template <typename Act>
void for_each_file(const fs::path& directory, const Act& act) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    const int file = ::open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
    const bool done = file >= 0 && act(file);
    if (file >= 0) ::close(file);
    if (!done) throw Error("cannot flush " + entry.path().string() + " to the disk");
  }
}

}  // namespace

build_lf::PackOptions bench_capture() {
  const SourceScene scene = source_scene();
  const fs::path capture = cache_of(scene) / "capture";
  if (!fs::exists(capture / "poses.csv")) make_capture(scene, capture);
  build_lf::PackOptions options;
  options.frames = capture / "poses.csv";
  options.distances = scene.directory / "dist";
  return options;
}

fs::path bench_room() {
  fs::path room = cache_of(source_scene()) / "room.lf";
  if (!can_be_opened(room)) {
    fs::remove_all(room);
    build_lf::PackOptions options = bench_capture();
    options.out = room;
    build_lf::pack_room(options);
  }
  // So that views read its files anew page by page: the big pieces in which pack has just written
  // them make views up to four times slower on some virtual machines.
  static std::once_flag once;
  std::call_once(once, drop_from_cache, room);
  return room;
}

fs::path bench_room(const RayForm& form) {
  if (!form.compressed()) return bench_room();
  const fs::path room = build_lf::default_repacked_name(bench_room(), form);
  if (!can_be_opened(room)) {
    fs::remove_all(room);
    build_lf::repack_room({.room = bench_room(), .out = room, .form = form});
  }
  return room;
}

std::vector<PlanPoint> viewpoints_in(const Cell& cell) {
  constexpr double kPlaces[][2] = {{0.5, 0.5},   {0.75, 0.75}, {0.25, 0.6},
                                   {0.56, 0.95}, {0.05, 0.9},  {0.13, 0.28}};
  std::vector<PlanPoint> points;
  for (const auto& place : kPlaces) {
    points.push_back({cell.x_min_m + place[0] * (cell.x_max_m - cell.x_min_m),
                      cell.z_min_m + place[1] * (cell.z_max_m - cell.z_min_m)});
  }
  return points;
}

void flush_to_disk(const fs::path& directory) {
  for_each_file(directory, [](int file) { return ::fsync(file) == 0; });
}

void drop_from_cache(const fs::path& directory) {
  for_each_file(directory, [](int file) {
    return ::fsync(file) == 0 && ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED) == 0;
  });
}

double number_of_process(const std::string& file, const std::string& key) {
  std::ifstream stream("/proc/self/" + file);
  for (std::string word; stream >> word;) {
    double number = 0.0;
    if (word == key + ":" && stream >> number) return number;
  }
  throw Error("/proc/self/" + file + " has no " + key + "; the benchmark needs Linux");
}

double bytes_under(const fs::path& directory) {
  double bytes = 0.0;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) bytes += static_cast<double>(entry.file_size());
  }
  return bytes;
}

}  // namespace raywalk::bench
