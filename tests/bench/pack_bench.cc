#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <vector>

#include "build_lf/pack/pack_room.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/timing.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kPairs = 3;

void flush_to_disk(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const bool flushed = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!flushed) throw Error("cannot flush " + file.string());
}

// Copies a directory and waits until the copy is on the disk. `to` must not exist.
void copy_to_disk(const fs::path& from, const fs::path& to) {
  fs::copy(from, to, fs::copy_options::recursive);
  for (const auto& entry : fs::recursive_directory_iterator(to)) {
    if (entry.is_regular_file()) flush_to_disk(entry.path());
  }
}

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
    copy_s.push_back(times_of([&] { copy_to_disk(options.out, copy); }).wall_s);
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
