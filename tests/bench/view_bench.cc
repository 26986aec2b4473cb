#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"
#include "core/panorama/pitch_remap.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

constexpr float kDistance_m = 2.0f;
constexpr auto kPiOfFloat = static_cast<float>(kPi);

struct NearStation {
  const std::uint8_t* rays = nullptr;  // rgb, [theta][phi]
  cv::Vec3f from_eye_m{};              // x, y, z
  float weight = 0.0f;
};

// The two stations around the place where a plan direction crosses the cell's border.
std::array<NearStation, 2> stations_around(const Room& room, PlanPoint eye, double theta_rad) {
  const double dx = std::sin(theta_rad), dz = std::cos(theta_rad);
  double nearest_m = std::numeric_limits<double>::infinity(), along_m = 0.0;
  int crossed = 0;
  for (const int index : room.grid().cells.front().line) {
    const Line& line = room.grid().lines[static_cast<std::size_t>(index)];
    const double x = line.origin.x_m - eye.x_m, z = line.origin.z_m - eye.z_m;
    const double across = dx * line.direction.z_m - dz * line.direction.x_m;
    const double ahead_m = (x * line.direction.z_m - z * line.direction.x_m) / across;
    if (!(ahead_m > 0.0 && ahead_m < nearest_m)) continue;
    nearest_m = ahead_m;
    along_m = (x * dz - z * dx) / across;
    crossed = index;
  }
  const std::vector<Station>& all = room.grid().lines[static_cast<std::size_t>(crossed)].stations;
  const auto after = std::upper_bound(all.begin() + 1, all.end() - 1, along_m,
                                      [](double m, const Station& s) { return m < s.along_m; });
  const double gap_m = after->along_m - (after - 1)->along_m;
  const double part = std::clamp((along_m - (after - 1)->along_m) / gap_m, 0.0, 1.0);
  std::array<NearStation, 2> two;
  for (int i = 0; i < 2; ++i) {
    const auto station = after - 1 + i;
    const Eigen::Vector3d& at = station->position_m;
    NearStation& near = two[static_cast<std::size_t>(i)];
    near.rays = room.volume(crossed).rays(static_cast<int>(station - all.begin()));
    near.from_eye_m = {static_cast<float>(at.x() - eye.x_m), 0.0f,
                       static_cast<float>(at.z() - eye.z_m)};
    near.weight = static_cast<float>(i == 0 ? 1.0 - part : part);
  }
  return two;
}

cv::Vec3f sample(const NearStation& station, PanoramaSize size, const cv::Vec3f& point_m) {
  const cv::Vec3f to = point_m - station.from_eye_m;
  const auto width = static_cast<float>(size.width), height = static_cast<float>(size.height);
  const float across_m = std::sqrt(to[0] * to[0] + to[2] * to[2]);
  const float u = (std::atan2(to[0], to[2]) / (2.0f * kPiOfFloat) + 0.5f) * width - 0.5f + width;
  const float v = std::clamp((0.5f - std::atan2(to[1], across_m) / kPiOfFloat) * height - 0.5f,
                             0.0f, height - 1.001f);
  const int left = static_cast<int>(u), upper = static_cast<int>(v);
  const float part_u = u - static_cast<float>(left), part_v = v - static_cast<float>(upper);
  cv::Vec3f sum;
  for (int i = 0; i < 2; ++i) {
    const std::uint8_t* const pixel =
        station.rays +
        3 * (static_cast<std::ptrdiff_t>((left + i) % size.width) * size.height + upper);
    const float weight = i == 0 ? 1.0f - part_u : part_u;
    for (int c = 0; c < 3; ++c) {
      const auto above = static_cast<float>(pixel[c]), below = static_cast<float>(pixel[3 + c]);
      sum[c] += weight * (above + part_v * (below - above));
    }
  }
  return sum;
}

// The yardstick: a plain program for views, which mixes the two nearest stations at a constant
// distance. It reads the same mapped panoramas in the same scattered way as a view, so that a
// machine on which that is slow slows both. The panorama has the size of the captured ones, 8-bit
// RGB, [theta][phi], at a viewpoint in the room's first cell. `to` is reused where it has the size.
void render_plainly(const Room& room, PlanPoint viewpoint, cv::Mat3b& to) {
  const PanoramaSize size = room.panorama();
  to.create(size.width, size.height);
  parallel_for(0, size.width, 16, [&](int begin, int end) {
    for (int u = begin; u < end; ++u) {
      const double theta_rad = (u + 0.5) / size.width * kTwoPi - kPi;
      const auto stations = stations_around(room, viewpoint, theta_rad);
      const auto dx = static_cast<float>(std::sin(theta_rad));
      const auto dz = static_cast<float>(std::cos(theta_rad));
      for (int v = 0; v < size.height; ++v) {
        const float phi_rad =
            (0.5f - (static_cast<float>(v) + 0.5f) / static_cast<float>(size.height)) * kPiOfFloat;
        const float across = std::cos(phi_rad);
        const cv::Vec3f point_m =
            kDistance_m * cv::Vec3f(across * dx, std::sin(phi_rad), across * dz);
        cv::Vec3f rgb;
        for (const NearStation& station : stations) {
          rgb += station.weight * sample(station, size, point_m);
        }
        to(u, v) = rgb;
      }
    }
  });
}

constexpr int kPairs = 12;
constexpr int kWalks = 3;
constexpr int kWalkSteps = 64;
constexpr double kWalkStep_m = 0.03;

// Of this process: VmRSS, its resident memory; VmHWM, the most since the last reset; RssFile, the
// resident pages of mapped files, of which Linux also maps up to 16 cached ones around each
// touched.
double status_bytes(const std::string& key) { return 1024.0 * number_of_process("status", key); }

// Growth of the resident set caused by one view of a room of which nothing has been read.
struct ResidentGrowth {
  double peak_bytes = 0.0;    // total
  double mapped_bytes = 0.0;  // of it mapped pages of the room's files
};

ResidentGrowth resident_growth(const ViewOptions& options) {
  const Room room = Room::open(bench_room());
  Renderer renderer(room, options);
  std::ofstream("/proc/self/clear_refs") << "5";  // resets VmHWM
  const double before = status_bytes("VmRSS");
  const double mapped_before = status_bytes("RssFile");
  renderer.render(viewpoints_in(room.grid().cells.front()).front());
  return {status_bytes("VmHWM") - before, status_bytes("RssFile") - mapped_before};
}

// Views, `render(i, viewpoint)`, at viewpoints distributed over the cell, relative to a cv::remap
// of 4096x2048 with the same number of threads. The two alternate, so that other load affects both,
// and each reuses the memory of its picture; `ratio` is the median over the pairs, `cpu_ratio` the
// same for processor time. `checked` is relative to render_plainly at the same viewpoint, which
// waits for the room's memory as a view does.
template <typename Render>
void compare(benchmark::State& state, const Room& room, const Render& render) {
  const std::vector<PlanPoint> viewpoints = viewpoints_in(room.grid().cells.front());
  const auto viewpoint_of = [&](std::size_t i) { return viewpoints[i % viewpoints.size()]; };
  for (std::size_t i = 0; i < kPairs; ++i) render(i, viewpoint_of(i));
  PitchRemap remap(kBenchWidth);
  remap.run();
  std::vector<double> view_s, remap_s, ratios, cpu_ratios, checked;
  cv::Mat3b plain;
  for (auto _ : state) {
    const std::size_t i = view_s.size();
    const Times plain_times = times_of([&] { render_plainly(room, viewpoint_of(i), plain); });
    const Times yardstick = times_of([&] { remap.run(); });
    const Times times = times_of([&] { render(i, viewpoint_of(i)); });
    view_s.push_back(times.wall_s);
    remap_s.push_back(yardstick.wall_s);
    ratios.push_back(times.wall_s / yardstick.wall_s);
    cpu_ratios.push_back(times.cpu_s / yardstick.cpu_s);
    checked.push_back(times.wall_s / plain_times.wall_s);
    state.SetIterationTime(times.wall_s);
  }
  state.counters["ratio"] = median(ratios);
  state.counters["cpu_ratio"] = median(cpu_ratios);
  state.counters["checked"] = median(checked);
  state.counters["view_ms"] = 1e3 * median(view_s);
  state.counters["remap_ms"] = 1e3 * median(remap_s);
}

// 4096x2048 views. `peak_MB` and `mapped_MB` are the ResidentGrowth, `room_MB` the size of the
// room.
void bench_options(benchmark::State& state, ViewOptions options) {
  options.k_deg = 76.0;
  options.width = kBenchWidth;
  const ResidentGrowth growth = resident_growth(options);
  const Room room = Room::open(bench_room());
  Renderer renderer(room, options);
  RenderedView view;
  compare(state, room, [&](std::size_t, PlanPoint viewpoint) {
    view = renderer.render(viewpoint, std::move(view));
    benchmark::DoNotOptimize(view.image.data);
  });
  state.counters["peak_MB"] = 1e-6 * growth.peak_bytes;
  state.counters["mapped_MB"] = 1e-6 * growth.mapped_bytes;
  state.counters["room_MB"] = 1e-6 * bytes_under(bench_room());
}

void bench_view(benchmark::State& state, ViewMethod method) {
  bench_options(state, {.method = method});
}

// The settings of the preset fast.
void bench_fast(benchmark::State& state, ViewMethod method) {
  ViewOptions fast{.method = method, .station_fade = 0.125, .distance_maps = 2};
  fast.second_side = SecondSide::kFaded;
  bench_options(state, fast);
}

// Both eyes of omnidirectional stereo, 4096x2048 each, relative to one view of the same size at the
// same viewpoint; the two alternate. `ratio` is the median over the pairs, `cpu_ratio` the same for
// processor time.
void bench_stereo(benchmark::State& state, ViewMethod method) {
  constexpr double kEyesApart_m = 0.063;
  const ViewOptions options{.method = method, .k_deg = 76.0, .width = kBenchWidth};
  const Room room = Room::open(bench_room());
  std::vector<PlanPoint> viewpoints = viewpoints_in(room.grid().cells.front());
  Renderer renderer(room, options);
  RenderedView one, both;
  for (const PlanPoint& viewpoint : viewpoints) {
    renderer.render(viewpoint, one);
    renderer.render_stereo(viewpoint, kEyesApart_m, both);
  }
  std::vector<double> both_s, ratios, cpu_ratios;
  for (auto _ : state) {
    const PlanPoint viewpoint = viewpoints[both_s.size() % viewpoints.size()];
    const Times of_one = times_of([&] { renderer.render(viewpoint, one); });
    const Times of_both = times_of([&] { renderer.render_stereo(viewpoint, kEyesApart_m, both); });
    benchmark::DoNotOptimize(both.image.data);
    both_s.push_back(of_both.wall_s);
    ratios.push_back(of_both.wall_s / of_one.wall_s);
    cpu_ratios.push_back(of_both.cpu_s / of_one.cpu_s);
    state.SetIterationTime(of_both.wall_s);
  }
  state.counters["ratio"] = state.counters["checked"] = median(ratios);
  state.counters["cpu_ratio"] = median(cpu_ratios);
  state.counters["view_ms"] = 1e3 * median(both_s);
}

// Perspective pictures with a field of view of 90 degrees, 1440 x 1600 pixels, that look straight
// ahead, up, down and tilted. Remap and render_plainly are of a whole panorama.
void bench_flat(benchmark::State& state, ViewMethod method) {
  const Room room = Room::open(bench_room());
  const std::array<Attitude, 4> looks{{{},
                                       {.yaw_rad = 2.0, .pitch_rad = -0.4, .roll_rad = 0.1},
                                       {.yaw_rad = -1.0, .pitch_rad = 0.2},
                                       {.yaw_rad = 3.1, .pitch_rad = -1.0}}};
  Renderer renderer(room, {.method = method, .k_deg = 76.0, .width = kBenchWidth});
  RenderedView flat;
  compare(state, room, [&](std::size_t i, PlanPoint viewpoint) {
    renderer.render(viewpoint, {.attitude = looks[i % looks.size()], .width = 1440, .height = 1600},
                    flat);
    benchmark::DoNotOptimize(flat.image.data);
  });
}

// A walk around the middle of the cell, kWalkSteps views kWalkStep_m apart, 2048 x 1024 each. `fps`
// is the number of views per second.
void bench_walk(benchmark::State& state, ViewMethod method) {
  const Room room = Room::open(bench_room());
  const Cell& cell = room.grid().cells.front();
  const PlanPoint middle{0.5 * (cell.x_min_m + cell.x_max_m), 0.5 * (cell.z_min_m + cell.z_max_m)};
  const double radius_m = kWalkSteps * kWalkStep_m / kTwoPi;
  Renderer renderer(room, {.method = method, .k_deg = 76.0, .width = kBenchWidth / 2});
  RenderedView view;
  const auto step_to = [&](int step) {
    const double angle_rad = kTwoPi * step / kWalkSteps;
    renderer.render(
        {middle.x_m + radius_m * std::sin(angle_rad), middle.z_m + radius_m * std::cos(angle_rad)},
        view);
    benchmark::DoNotOptimize(view.image.data);
  };
  for (int step = 0; step < kWalkSteps; ++step) step_to(step);
  std::vector<double> frames_per_s;
  for (auto _ : state) {
    const Times times = times_of([&] {
      for (int step = 0; step < kWalkSteps; ++step) step_to(step);
    });
    frames_per_s.push_back(kWalkSteps / times.wall_s);
    state.SetIterationTime(times.wall_s);
  }
  state.counters["fps"] = median(frames_per_s);
}

void pairs(benchmark::internal::Benchmark* benchmark) {
  benchmark->Iterations(kPairs)->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(bench_walk, hlf_vd, ViewMethod::kHlfVd)->Apply(pairs)->Iterations(kWalks);
BENCHMARK_CAPTURE(bench_walk, two_sided, ViewMethod::kTwoSided)->Apply(pairs)->Iterations(kWalks);

BENCHMARK_CAPTURE(bench_flat, initial, ViewMethod::kInitial)->Apply(pairs);
BENCHMARK_CAPTURE(bench_flat, hlf_vd, ViewMethod::kHlfVd)->Apply(pairs);
BENCHMARK_CAPTURE(bench_flat, two_sided, ViewMethod::kTwoSided)->Apply(pairs);

BENCHMARK_CAPTURE(bench_stereo, initial, ViewMethod::kInitial)->Apply(pairs);
BENCHMARK_CAPTURE(bench_stereo, hlf_vd, ViewMethod::kHlfVd)->Apply(pairs);
BENCHMARK_CAPTURE(bench_stereo, two_sided, ViewMethod::kTwoSided)->Apply(pairs);

BENCHMARK_CAPTURE(bench_fast, hlf_vd, ViewMethod::kHlfVd)->Apply(pairs);
BENCHMARK_CAPTURE(bench_fast, two_sided, ViewMethod::kTwoSided)->Apply(pairs);

BENCHMARK_CAPTURE(bench_view, initial, ViewMethod::kInitial)->Apply(pairs);
BENCHMARK_CAPTURE(bench_view, hlf_vd, ViewMethod::kHlfVd)->Apply(pairs);
BENCHMARK_CAPTURE(bench_view, two_sided, ViewMethod::kTwoSided)->Apply(pairs);
BENCHMARK_CAPTURE(bench_options, sixteen_stations,
                  {.method = ViewMethod::kTwoSided, .stations_mixed = 16})
    ->Apply(pairs);

}  // namespace

}  // namespace raywalk::bench
