// Times that depend on the disk: to the first view of a room, of compressed rooms, and of packing.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kRounds = 5;

// By this process so far.
double bytes_read_from_disk() { return number_of_process("io", "read_bytes"); }

// As far as memory permits.
void read_room_into_cache(const fs::path& room) {
  std::vector<char> piece(std::size_t{4} << 20);
  for (const auto& entry : fs::recursive_directory_iterator(room)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    while (file.read(piece.data(), static_cast<std::streamsize>(piece.size()))) continue;
  }
}

// Time to the first view of a room, with its files in the page cache or not. `open_ms` and
// `view_ms` are the parts, `read_MB` the data read from the disk.
void bench_first_view(benchmark::State& state, ViewMethod method, bool cold,
                      const RayForm& form = {}) {
  const fs::path directory = bench_room(form);
  const ViewOptions options{.method = method, .k_deg = 76.0, .width = kBenchWidth};
  const auto places = viewpoints_in(Room::open(directory).grid().cells.front());
  if (!cold) read_room_into_cache(directory);
  std::vector<double> open_s, view_s, total_s, read_bytes;
  for (auto _ : state) {
    if (cold) drop_from_cache(directory);
    const double read_before = bytes_read_from_disk();
    const PlanPoint viewpoint = places[total_s.size() % places.size()];
    Room room;
    open_s.push_back(times_of([&] { room = Room::open(directory); }).wall_s);
    const Times first =
        times_of([&] { benchmark::DoNotOptimize(Renderer(room, options).render(viewpoint)); });
    view_s.push_back(first.wall_s);
    total_s.push_back(open_s.back() + view_s.back());
    read_bytes.push_back(bytes_read_from_disk() - read_before);
    state.SetIterationTime(total_s.back());
  }
  state.counters["open_ms"] = 1e3 * median(open_s);
  state.counters["view_ms"] = 1e3 * median(view_s);
  state.counters["first_view_ms"] = 1e3 * median(total_s);
  state.counters["read_MB"] = 1e-6 * median(read_bytes);
}

// The same of rooms whose panoramas are compressed (forms of bench_decoded_view), two-sided.
const std::vector<RayForm>& forms() {
  static const std::vector<RayForm> forms = {
      {}, {RayForm::Kind::kLossless, 0}, {RayForm::Kind::kJpeg, 95}, {RayForm::Kind::kJpeg, 90}};
  return forms;
}

const RayForm& form_of(const benchmark::State& state) {
  return forms()[static_cast<std::size_t>(state.range(0))];
}

void bench_first_view_of_form(benchmark::State& state) {
  bench_first_view(state, ViewMethod::kTwoSided, state.range(1) != 0, form_of(state));
  state.SetLabel(name_of(form_of(state)) + (state.range(1) != 0 ? ", cold" : ", warm"));
}

// A view again: compressed panoramas are decoded then. `ratio` to the same view of the room without
// compression, both in turn; `size_ratio` of the files with the panoramas.
void bench_decoded_view(benchmark::State& state) {
  const fs::path directory = bench_room(form_of(state));
  const ViewOptions options{.method = ViewMethod::kTwoSided, .k_deg = 76.0, .width = kBenchWidth};
  const Room raw = Room::open(bench_room());
  const Room room = Room::open(directory);
  Renderer raw_views(raw, options);
  Renderer views(room, options);
  const auto places = viewpoints_in(room.grid().cells.front());
  std::vector<double> raw_s, view_s;
  for (auto _ : state) {
    for (const PlanPoint place : places) {
      RenderedView view = views.render(place);
      view = raw_views.render(place, std::move(view));
      for (int repetition = 0; repetition < 3; ++repetition) {
        raw_s.push_back(times_of([&] { view = raw_views.render(place, std::move(view)); }).wall_s);
        view_s.push_back(times_of([&] { view = views.render(place, std::move(view)); }).wall_s);
      }
    }
    state.SetIterationTime(median(view_s));
  }
  state.counters["ratio"] = median(view_s) / median(raw_s);
  state.counters["size_ratio"] =
      bytes_under(directory / "lines") / bytes_under(bench_room() / "lines");
  state.SetLabel(name_of(form_of(state)));
}

void rounds(benchmark::internal::Benchmark* benchmark) {
  benchmark->Iterations(kRounds)->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK(bench_first_view_of_form)->ArgsProduct({{0, 1, 2, 3}, {0, 1}})->Apply(rounds);
BENCHMARK(bench_decoded_view)->DenseRange(0, 3)->Apply(rounds)->Iterations(2);
BENCHMARK_CAPTURE(bench_first_view, cold_initial, ViewMethod::kInitial, true)->Apply(rounds);
BENCHMARK_CAPTURE(bench_first_view, cold_hlf_vd, ViewMethod::kHlfVd, true)->Apply(rounds);
BENCHMARK_CAPTURE(bench_first_view, cold_two_sided, ViewMethod::kTwoSided, true)->Apply(rounds);
BENCHMARK_CAPTURE(bench_first_view, warm_initial, ViewMethod::kInitial, false)->Apply(rounds);
BENCHMARK_CAPTURE(bench_first_view, warm_hlf_vd, ViewMethod::kHlfVd, false)->Apply(rounds);
BENCHMARK_CAPTURE(bench_first_view, warm_two_sided, ViewMethod::kTwoSided, false)->Apply(rounds);

constexpr int kPairs = 3;

// Packing a capture of 4096x2048 JPEG frames with distance maps, relative to a plain copy of the
// packed files. Both include flushing to the disk.
void bench_pack(benchmark::State& state) {
  build_lf::PackOptions options = bench_capture();
  const fs::path work = options.frames.parent_path().parent_path();
  options.out = work / "packed.lf";
  const fs::path copy = work / "copied.lf";
  const double bytes = bytes_under(bench_room());

  std::vector<double> pack_s, copy_s, ratios;
  for (auto _ : state) {
    fs::remove_all(options.out);
    fs::remove_all(copy);
    pack_s.push_back(times_of([&] { build_lf::pack_room(options); }).wall_s);
    copy_s.push_back(times_of([&] {
                       fs::copy(options.out, copy, fs::copy_options::recursive);
                       flush_to_disk(copy);
                     }).wall_s);
    ratios.push_back(pack_s.back() / copy_s.back());
    state.SetIterationTime(pack_s.back());
  }
  fs::remove_all(options.out);
  fs::remove_all(copy);
  state.counters["ratio"] = median(ratios);
  state.counters["pack_MB_per_s"] = 1e-6 * bytes / median(pack_s);
  state.counters["copy_MB_per_s"] = 1e-6 * bytes / median(copy_s);
}

BENCHMARK(bench_pack)->Iterations(kPairs)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace raywalk::bench
