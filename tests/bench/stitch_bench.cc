#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibrate/stitch/stitcher.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "simulator/room/virtual_room.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kPairs = 5;
constexpr int kFrames = 8;  // per measurement
constexpr double kFieldOfView_deg = 190.0;
constexpr PanoramaSize kPanorama{kBenchWidth, kBenchWidth / 2};

// The dual-fisheye model of ffmpeg's v360: two equidistant circles that fill the halves of the
// frame. Its resolution at the centres is that of the panorama.
DualFisheyeCamera ideal_camera() {
  const double half_view = radians_from_degrees(0.5 * kFieldOfView_deg);
  const int height = 2 * static_cast<int>(std::lround(half_view * kBenchWidth / kTwoPi));
  DualFisheyeCamera camera;
  camera.picture = {2 * height, height};
  camera.layout = simple_dual_fisheye(camera.picture);
  camera.layout.front.focal_px = camera.layout.back.focal_px = 0.5 * height / half_view;
  return camera;
}

double psnr_db(const cv::Mat& a, const cv::Mat& b) {
  const double distance = cv::norm(a, b, cv::NORM_L2);
  return 10.0 *
         std::log10(255.0 * 255.0 * 3.0 * static_cast<double>(a.total()) / (distance * distance));
}

// Processor time of all finished child processes.
double children_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// ffmpeg on raw planar frames, the native format of its filter, so that only the filter and reading
// from memory are measured.
class FfmpegStitcher {
 public:
  FfmpegStitcher(const cv::Mat& frame, std::string interpolation)
      : size_(frame.size()),
        interpolation_(std::move(interpolation)),
        input_(fs::path(RAYWALK_BENCH_DIR) / "dual_fisheye.raw"),
        output_(fs::path(RAYWALK_BENCH_DIR) / "panorama.raw") {
    std::vector<cv::Mat> planes;
    cv::split(frame, planes);
    std::ofstream file(input_, std::ios::binary);
    for (int i = 0; i <= kFrames; ++i) {
      for (const int plane : kPlanes) {
        file.write(planes[static_cast<std::size_t>(plane)].ptr<char>(),
                   static_cast<std::streamsize>(frame.total()));
      }
    }
    if (!file.flush()) throw Error("cannot write " + input_.string());
  }
  ~FfmpegStitcher() {
    std::error_code ignored;
    fs::remove(input_, ignored);
    fs::remove(output_, ignored);
  }
  FfmpegStitcher(const FfmpegStitcher&) = delete;
  FfmpegStitcher& operator=(const FfmpegStitcher&) = delete;

  // Time per frame. Start-up and filter tables, which do not depend on the number of frames, are
  // subtracted.
  Times frame_times() const {
    const Times one = measure(1), all = measure(1 + kFrames);
    return {(all.wall_s - one.wall_s) / kFrames, (all.cpu_s - one.cpu_s) / kFrames};
  }

  cv::Mat panorama() const {
    run(1, "-f rawvideo " + output_.string());
    const std::string bytes = read_file(output_);
    std::vector<cv::Mat> planes(3);
    const auto pixels = static_cast<std::size_t>(kPanorama.width) * kPanorama.height;
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const cv::Mat plane(kPanorama.height, kPanorama.width, CV_8UC1,
                          const_cast<char*>(bytes.data() + i * pixels));
      planes[static_cast<std::size_t>(kPlanes[i])] = plane;
    }
    cv::Mat merged;
    cv::merge(planes, merged);
    return merged;
  }

 private:
  // OpenCV's BGR channels in the order of ffmpeg's gbrp.
  static constexpr int kPlanes[3] = {1, 0, 2};

  Times measure(int frames) const {
    const double cpu_before_s = children_cpu_s();
    const double wall_s = times_of([&] { run(frames, "-f null -"); }).wall_s;
    return {wall_s, children_cpu_s() - cpu_before_s};
  }

  // v360 has the front in the right circle.
  void run(int frames, const std::string& to) const {
    const std::string command = fmt::format(
        "ffmpeg -v error -y -f rawvideo -pix_fmt gbrp -s {}x{} -i {} -frames:v {} -filter_threads "
        "{} -vf v360=dfisheye:e:ih_fov={}:iv_fov={}:yaw=180:w={}:h={}:interp={} {}",
        size_.width, size_.height, input_.string(), frames, thread_count(), kFieldOfView_deg,
        kFieldOfView_deg, kPanorama.width, kPanorama.height, interpolation_, to);
    if (std::system(command.c_str()) != 0) throw Error("ffmpeg failed: " + command);
  }

  cv::Size size_;
  std::string interpolation_;
  fs::path input_;
  fs::path output_;
};

struct Scene {
  DualFisheyeCamera camera = ideal_camera();
  cv::Mat frame{};
  cv::Mat truth{};
};

const Scene& scene() {
  static const Scene made = [] {
    Scene fresh;
    const simulator::VirtualRoom room(simulator::VirtualRoomSettings{});
    const simulator::CameraPose pose{{0.1, 0.0, 0.05}, {0.3, 0.1, 0.05}};
    fresh.frame =
        room.render(simulator::DualFisheyeRays(fresh.camera.layout, fresh.camera.picture), pose);
    fresh.truth = room.render(simulator::PanoramaRays(kPanorama), pose);
    return fresh;
  }();
  return made;
}

Times stitching_times(const calibrate::Stitcher& stitcher) {
  const auto work = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) benchmark::DoNotOptimize(stitcher.stitch(scene().frame));
  };
  const Times all = times_of([&] { parallel_for(0, kFrames, 1, work); });
  return {all.wall_s / kFrames, all.cpu_s / kFrames};
}

// Stitching of dual-fisheye frames to 4096x2048 panoramas, memory to memory, relative to ffmpeg's
// v360 filter on the same frames with the same number of threads. The two alternate; `ratio` is the
// median over the pairs of Raywalk's time to ffmpeg's (below 1: Raywalk is faster), `cpu_ratio` the
// same for processor time. psnr_db and ffmpeg_psnr_db are relative to the ray-traced panorama.
void bench_stitch(benchmark::State& state, calibrate::BlendMethod blend,
                  const std::string& interpolation) {
  const FfmpegStitcher ffmpeg(scene().frame, interpolation);
  const calibrate::Stitcher stitcher(scene().camera, kPanorama.width, {.blend = blend});
  std::vector<double> ours_s, ffmpeg_s, ratios, cpu_ratios;
  for (auto _ : state) {
    const Times theirs = ffmpeg.frame_times();
    const Times ours = stitching_times(stitcher);
    ffmpeg_s.push_back(theirs.wall_s);
    ours_s.push_back(ours.wall_s);
    ratios.push_back(ours.wall_s / theirs.wall_s);
    cpu_ratios.push_back(ours.cpu_s / theirs.cpu_s);
    state.SetIterationTime(ours.wall_s);
  }
  state.counters["ratio"] = median(ratios);
  state.counters["cpu_ratio"] = median(cpu_ratios);
  state.counters["stitch_ms"] = 1e3 * median(ours_s);
  state.counters["ffmpeg_ms"] = 1e3 * median(ffmpeg_s);
  state.counters["psnr_db"] = psnr_db(stitcher.stitch(scene().frame), scene().truth);
  state.counters["ffmpeg_psnr_db"] = psnr_db(ffmpeg.panorama(), scene().truth);
}

BENCHMARK_CAPTURE(bench_stitch, feather_against_linear, calibrate::BlendMethod::kFeather, "linear")
    ->Iterations(kPairs)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_stitch, feather_against_cubic, calibrate::BlendMethod::kFeather, "cubic")
    ->Iterations(kPairs)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_stitch, multi_band_against_cubic, calibrate::BlendMethod::kMultiBand,
                  "cubic")
    ->Iterations(kPairs)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace raywalk::bench
