#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <thread>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/finish_maps.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/depth/sweep_depth.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"
#include "tests/bench/bench_room.h"
#include "tests/bench/plain_copy.h"
#include "tests/bench/resident_memory.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

// Peak anonymous memory of this process during the object's lifetime. Mapped pages of the room's
// files do not count, as the kernel can evict them.
class PeakOwnMemory {
 public:
  PeakOwnMemory() : start_bytes_(own_bytes()), sampler_([this] { sample(); }) {}
  ~PeakOwnMemory() { stop(); }
  PeakOwnMemory(const PeakOwnMemory&) = delete;
  PeakOwnMemory& operator=(const PeakOwnMemory&) = delete;

  // Increase since the start; ends the measurement.
  double growth_bytes() {
    stop();
    return peak_bytes_ - start_bytes_;
  }

 private:
  static double own_bytes() { return resident_bytes() - mapped_resident_bytes(); }
  void sample() {
    while (!stopped_) {
      peak_bytes_ = std::max(peak_bytes_, own_bytes());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  void stop() {
    stopped_ = true;
    if (sampler_.joinable()) sampler_.join();
  }

  double start_bytes_;
  double peak_bytes_ = 0.0;
  std::atomic<bool> stopped_{false};
  std::thread sampler_;
};

// The room's plan with `count` of its maps, distributed over all lines.
build_lf::DepthPlan plan_of(const Room& room, size_t count) {
  build_lf::DepthPlan plan = build_lf::plan_depth(room, {.every = 1});
  const std::vector<build_lf::SweepReference> all = std::move(plan.maps);
  plan.maps.clear();
  for (size_t i = 0; i < count; ++i) plan.maps.push_back(all[i * all.size() / count]);
  return plan;
}

// Estimates distance maps 1024 wide for a number of stations, from panoramas to fused maps. Time
// should be linear in the stations (`s_per_map` constant) and memory constant (`peak_MB`).
// `MB_per_s` is the throughput in panorama bytes, `copy_MB_per_s` that of a plain copy of a volume
// in the same run.
void bench_depth(benchmark::State& state) {
  const Room room = Room::open(bench_room());
  const build_lf::DepthPlan plan = plan_of(room, static_cast<size_t>(state.range(0)));
  const fs::path work = bench_room().parent_path() / "depth";
  double peak_bytes = 0.0;
  std::vector<double> seconds;
  std::vector<double> cpu_seconds;
  for (auto _ : state) {
    fs::remove_all(work);
    fs::create_directories(work);
    build_lf::PartialMaps partial(work, "bench");
    PeakOwnMemory memory;
    const GainFields fields = unit_gain_fields(room.grid());
    const Times times = times_of([&] {
      const build_lf::IndexRange all{0, plan.maps.size()};
      const double max_per_m =
          build_lf::sweep_coarse_maps(room, plan, {}, "coarse", &partial).nearest_per_m;
      build_lf::sweep_maps(room, plan, max_per_m, fields, {}, all, &partial);
      build_lf::choose_maps(room, plan, fields, {}, all, &partial);
      build_lf::fuse_chosen_maps(room, plan, fields, all, &partial);
    });
    peak_bytes = std::max(peak_bytes, memory.growth_bytes());
    seconds.push_back(times.wall_s);
    cpu_seconds.push_back(times.cpu_s);
    state.SetIterationTime(times.wall_s);
  }
  fs::remove_all(work);
  const fs::path volume = line_volume_path(bench_room(), room.grid().lines.front().id);
  const double copy_s = times_of([&] { copy_to_disk(volume, work); }).wall_s;
  fs::remove_all(work);
  const auto maps = static_cast<double>(plan.maps.size());
  state.counters["s_per_map"] = median(seconds) / maps;
  state.counters["cpu_s_per_map"] = median(cpu_seconds) / maps;
  const PanoramaSize size = room.panorama();
  state.counters["MB_per_s"] = 3e-6 * size.width * size.height * maps / median(seconds);
  state.counters["copy_MB_per_s"] = 1e-6 * static_cast<double>(fs::file_size(volume)) / copy_s;
  state.counters["peak_MB"] = 1e-6 * peak_bytes;
}

BENCHMARK(bench_depth)
    ->RangeMultiplier(2)
    ->Range(2, 8)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace raywalk::bench
