// The steps of rendering a view (core/view/view_inputs.h), each alone: on one thread, for all
// columns of a 4096 x 2048 view. `ns_per_px` is the median time per output pixel. What a step needs
// of those before it is computed outside the time.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/room/room.h"
#include "core/view/column_arrays.h"
#include "core/view/test_steps.h"
#include "tests/bench/bench_room.h"
#include "tests/bench/thread_count.h"

namespace raywalk::bench {
namespace {

constexpr int kPasses = 3;  // over all columns
constexpr double kNsPerPx_s = 1e9 / (0.5 * kBenchWidth * kBenchWidth);

// A view of the bench room on one thread, and what its columns are rendered into.
class StepsView {
 public:
  explicit StepsView(Generation generation) : room_(Room::open(bench_room())) {
    set_thread_count(1);
    at_ = viewpoints_in(room_.grid().cells.front())[1];
    prepared_ = std::make_unique<PreparedSteps>(
        room_, ViewOptions{.generation = generation, .k_deg = 76.0, .width = kBenchWidth}, at_);
    for (int u = 0; u < kBenchWidth; ++u) sources_.push_back(prepared_->sources(u));
    rgb_.resize(3 * static_cast<size_t>(rows().end) + 1);  // a byte beyond is scratch
  }

  ViewSteps& steps() { return prepared_->steps; }
  const std::vector<RaySource>& sources(int u) const { return sources_[static_cast<size_t>(u)]; }
  RowRun rows() const { return prepared_->view.rows; }
  std::uint8_t* rgb() { return rgb_.data(); }
  void prepare() { prepared_->renderer.prepare(at_); }

 private:
  ThreadCount restored_;
  Room room_;
  PlanPoint at_;
  std::unique_ptr<PreparedSteps> prepared_;
  std::vector<std::vector<RaySource>> sources_;
  std::vector<std::uint8_t> rgb_;
};

// Wall time alone: reading the processor's time would take as long as some of the steps.
template <typename Work>
double seconds_of(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Times what `column(u)` returns, once it has returned.
template <typename Column>
void time_columns(benchmark::State& state, const Column& column) {
  std::vector<double> ns;
  for (auto _ : state) {
    double seconds = 0.0;
    for (int u = 0; u < kBenchWidth; ++u) seconds += seconds_of(column(u));
    ns.push_back(seconds * kNsPerPx_s);
    state.SetIterationTime(seconds);
  }
  state.counters["ns_per_px"] = median(ns);
}

// Planning the view and gathering its distances, from maps read before.
void bench_step_prepare(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  std::vector<double> ns;
  for (auto _ : state) {
    const double seconds = seconds_of([&] { view.prepare(); });
    ns.push_back(seconds * kNsPerPx_s);
    state.SetIterationTime(seconds);
  }
  state.counters["ns_per_px"] = median(ns);
}

void bench_step_distances(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  time_columns(state, [&](int u) {
    return [&view, u] { benchmark::DoNotOptimize(view.steps().distances.prepare(u)); };
  });
}

// Visibility and shares.
void bench_step_weights(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  time_columns(state, [&](int u) {
    const ColumnPoints& points = view.steps().distances.prepare(u);
    return [&view, &points, u] {
      benchmark::DoNotOptimize(view.steps().weights.weigh(points, view.sources(u)));
    };
  });
}

// Positions in both stations of every line.
void bench_step_positions(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  PositionArrays positions(view.rows().end);
  time_columns(state, [&](int u) {
    const ColumnPoints& points = view.steps().distances.prepare(u);
    return [&view, &positions, &points, u] {
      for (const RaySource& source : view.sources(u)) {
        for (int next = 0; next < 2; ++next) {
          benchmark::DoNotOptimize(view.steps().positions.find(
              points, source.line, source.station + next, view.rows(), positions.positions()));
        }
      }
    };
  });
}

// Samples and their mix, and the positions that they are read at.
void bench_step_mixing(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  time_columns(state, [&](int u) {
    const ColumnPoints& points = view.steps().distances.prepare(u);
    const ColumnShares& shares = view.steps().weights.weigh(points, view.sources(u));
    return [&view, &points, &shares, u] {
      view.steps().mixing.mix(points, view.sources(u), shares, view.rows(), view.rgb());
      benchmark::DoNotOptimize(view.rgb());
    };
  });
}

// `hidden_share` is the part of the pixels that are filled from other stations or stretched.
void bench_step_hidden(benchmark::State& state, Generation generation) {
  StepsView view(generation);
  HiddenPixels& hidden = view.steps().hidden;
  time_columns(state, [&](int u) {
    const ColumnPoints& points = view.steps().distances.prepare(u);
    const ColumnShares& shares = view.steps().weights.weigh(points, view.sources(u));
    view.steps().mixing.mix(points, view.sources(u), shares, view.rows(), view.rgb());
    return [&view, &hidden, &points, &shares] {
      if (!shares.any_hidden) return;
      hidden.fill(points, shares.hidden, view.rgb());
      hidden.stretch(
          points, view.rows(), [](int) {}, view.rgb());
      benchmark::DoNotOptimize(view.rgb());
    };
  });
  state.counters["hidden_share"] = static_cast<double>(hidden.filled() + hidden.stretched()) * 2.0 /
                                   kPasses / kBenchWidth / kBenchWidth;
}

BENCHMARK_CAPTURE(bench_step_prepare, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_prepare, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_distances, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_distances, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_weights, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_weights, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_positions, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_positions, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_mixing, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_mixing, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_hidden, hlf_vd, Generation::kHlfVd)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(bench_step_hidden, two_sided, Generation::kTwoSided)
    ->Iterations(kPasses)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace raywalk::bench
