// What grows with the size of a room, in halls of many cells.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "build_lf/pack/pack_room.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/geometry/grid.h"
#include "core/room/room.h"
#include "core/view/map_choice.h"
#include "core/view/renderer.h"
#include "core/view/view_plan.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

// A grid of square cells of 1 m; lines share the stations where they cross.
struct Hall {
  int columns = 1;   // cells along x
  int rows = 1;      // and along z
  int steps = 50;    // between two intersections
  int overhang = 0;  // steps of every line beyond the outermost intersections
};

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

// A square hall with about so many stations, 2 cm apart.
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
      const bool intersection = i % hall.steps == 0 && i >= 0 && i <= hall.rows * hall.steps;
      if (!intersection) add('z', line, i, line, i / static_cast<double>(hall.steps));
    }
  }
  return stations;
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

// The hall's room, with one and the same picture of `width` x width/2 pixels at every station and a
// distance map at every second one; packed on the first call and kept in the build tree.
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

constexpr Hall kLargeHall{56, 6, 50, 0};  // 36,365 stations on 64 lines, 336 cells
constexpr int kTinyWidth = 64;

// Finding lines and cells of about `range(0)` stations. `us_per_station` grows with the number of
// lines.
void bench_find_grid(benchmark::State& state) {
  const std::vector<StationPose> stations = stations_of(hall_of(static_cast<int>(state.range(0))));
  std::size_t cells = 0;
  std::vector<double> times_s;
  for (auto _ : state) {
    times_s.push_back(times_of([&] { cells = find_grid(stations, {}).cells.size(); }).wall_s);
    state.SetIterationTime(times_s.back());
  }
  state.counters["stations"] = static_cast<double>(stations.size());
  state.counters["cells"] = static_cast<double>(cells);
  state.counters["us_per_station"] = 1e6 * median(times_s) / static_cast<double>(stations.size());
}

BENCHMARK(bench_find_grid)
    ->Arg(10000)
    ->Arg(36700)
    ->Arg(100000)
    ->Arg(1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void bench_open_hall(benchmark::State& state) {
  const std::filesystem::path directory = hall_room(kLargeHall, kTinyWidth);
  for (auto _ : state) benchmark::DoNotOptimize(Room::open(directory));
}

BENCHMARK(bench_open_hall)->Unit(benchmark::kMillisecond);

// What a view of a large hall takes before its first distance is gathered: its lines, connections,
// height and the maps it uses.
void bench_plan_view(benchmark::State& state) {
  const Room room = Room::open(hall_room(kLargeHall, kTinyWidth));
  const Cell& cell = room.grid().cells[room.grid().cells.size() / 2];
  const std::vector<PlanPoint> places = viewpoints_in(cell);
  const ConnectionRule rule{radians_from_degrees(76.0), radians_from_degrees(5.0)};
  std::size_t next = 0;
  for (auto _ : state) {
    const ViewPlan plan(room.grid(), places[next++ % places.size()], rule);
    const MapSpread spread = map_spread(room.grid(), plan.viewpoint());
    benchmark::DoNotOptimize(nearest_maps(room, plan.lines(), plan.eye().centre_m, spread.gap_m,
                                          spread.most_per_line, 8));
  }
}

BENCHMARK(bench_plan_view)->Unit(benchmark::kMicrosecond);

// A view of a hall of many cells relative to one of a single cell with the same pictures and
// spacing (`ratio`): medians over views that alternate between the two. Lines go on for a cell
// beyond their last intersections: without that a single cell would mix fewer lines near its
// corners.
void bench_view_in_hall(benchmark::State& state, ViewMethod method) {
  constexpr int kSteps = 6, kWidth = 512, kWarmViews = 2;
  const Hall halls[] = {
      {1, 1, kSteps, kSteps},
      {static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), kSteps, kSteps}};
  std::vector<Room> rooms;
  for (const Hall& hall : halls) rooms.push_back(Room::open(hall_room(hall, kWidth)));
  std::deque<Renderer> renderers;
  std::array<std::vector<PlanPoint>, 2> places;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    renderers.emplace_back(rooms[i], ViewOptions{.method = method, .k_deg = 76.0, .width = kWidth});
    const auto& cells = rooms[i].grid().cells;
    places[i] = viewpoints_in(cells[cells.size() / 2]);
  }
  std::array<RenderedView, 2> views;
  const auto render = [&](std::size_t i, std::size_t round) {
    const PlanPoint at = places[i][round % places[i].size()];
    return times_of([&] { renderers[i].render(at, views[i]); }).wall_s;
  };
  for (std::size_t round = 0; round < kWarmViews * places[0].size(); ++round) {
    for (std::size_t i = 0; i < rooms.size(); ++i) render(i, round);
  }
  std::vector<double> ratios, times_s;
  std::size_t round = 0;
  for (auto _ : state) {
    const bool swapped = round % 2 == 1;
    std::array<double, 2> of_both{};
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t which = swapped ? 1 - i : i;
      of_both[which] = render(which, round);
    }
    ratios.push_back(of_both[1] / of_both[0]);
    times_s.push_back(of_both[1]);
    state.SetIterationTime(of_both[1]);
    ++round;
  }
  state.counters["cells"] = static_cast<double>(rooms[1].grid().cells.size());
  state.counters["view_ms"] = 1e3 * median(times_s);
  state.counters["ratio"] = median(ratios);
}

void hall_sizes(benchmark::internal::Benchmark* benchmark) {
  constexpr int kViews = 120;
  for (const auto& [columns, rows] : {std::pair(1, 1), {4, 3}, {14, 6}, {56, 6}}) {
    benchmark->Args({columns, rows});
  }
  benchmark->Iterations(kViews)->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(bench_view_in_hall, initial, ViewMethod::kInitial)->Apply(hall_sizes);
BENCHMARK_CAPTURE(bench_view_in_hall, hlf_vd, ViewMethod::kHlfVd)->Apply(hall_sizes);
BENCHMARK_CAPTURE(bench_view_in_hall, two_sided, ViewMethod::kTwoSided)->Apply(hall_sizes);

}  // namespace

}  // namespace raywalk::bench
