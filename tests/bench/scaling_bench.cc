#include <benchmark/benchmark.h>

#include <vector>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/timing.h"
#include "core/panorama/pitch_remap.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

constexpr int kRounds = 12;

// Restores the number of threads on destruction.
class ThreadCount {
 public:
  ThreadCount() = default;
  ~ThreadCount() { set_thread_count(before_); }
  ThreadCount(const ThreadCount&) = delete;
  ThreadCount& operator=(const ThreadCount&) = delete;

 private:
  int before_ = thread_count();
};

// Speedup of a view from one to two threads, relative to that of cv::remap on the same machine
// (`relative`). Each round measures all four times, so that other load affects them alike; results
// are medians over the rounds.
void bench_scaling(benchmark::State& state, ViewMethod method) {
  const ThreadCount restored;
  const Room room = Room::open(bench_room());
  const std::vector<PlanPoint> viewpoints = viewpoints_in(room.grid().cells.front());
  Renderer renderer(room, {.method = method, .k_deg = 76.0, .width = kBenchWidth});
  RenderedView view;
  for (const PlanPoint& viewpoint : viewpoints) view = renderer.render(viewpoint, std::move(view));
  PitchRemap remap(kBenchWidth);
  remap.run();

  std::vector<double> view_gains, remap_gains, relative;
  for (auto _ : state) {
    const PlanPoint viewpoint = viewpoints[relative.size() % viewpoints.size()];
    double view_s[2];
    double remap_s[2];
    for (int extra = 0; extra < 2; ++extra) {
      set_thread_count(1 + extra);
      remap_s[extra] = times_of([&] { remap.run(); }).wall_s;
      view_s[extra] = times_of([&] { view = renderer.render(viewpoint, std::move(view)); }).wall_s;
    }
    view_gains.push_back(view_s[0] / view_s[1]);
    remap_gains.push_back(remap_s[0] / remap_s[1]);
    relative.push_back(view_gains.back() / remap_gains.back());
    state.SetIterationTime(view_s[1]);
  }
  state.counters["view_gain"] = median(view_gains);
  state.counters["remap_gain"] = median(remap_gains);
  state.counters["relative"] = median(relative);
}

BENCHMARK_CAPTURE(bench_scaling, initial, ViewMethod::kInitial)
    ->Iterations(kRounds)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_scaling, hlf_vd, ViewMethod::kHlfVd)
    ->Iterations(kRounds)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_scaling, two_sided, ViewMethod::kTwoSided)
    ->Iterations(kRounds)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace raywalk::bench
