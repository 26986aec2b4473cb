// raywalk-bench: times of views and packing relative to cv::remap and to plain programs, and
// accuracy of the error model.
#include <benchmark/benchmark.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/command_line/program.h"
#include "core/view/gpu/gpu_device.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

// Passes unknown flags on to Google Benchmark. Results are written to a JSON file by default; of
// repeated flags Google Benchmark uses the last.
void run_benchmarks(const std::string& program, const std::vector<std::string>& flags) {
  std::vector<std::string> words = {program, "--benchmark_out=" RAYWALK_BENCH_DIR "/results.json",
                                    "--benchmark_out_format=json",
                                    "--benchmark_counters_tabular=true"};
  words.insert(words.end(), flags.begin(), flags.end());
  std::vector<char*> arguments;
  arguments.reserve(words.size());
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) {
    throw UsageError("unknown flag; see --help and Google Benchmark's --benchmark_* flags");
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}

}  // namespace
}  // namespace raywalk::bench

int main(int argc, char** argv) {
  CLI::App app("Benchmarks of Raywalk; --benchmark_* flags are passed to Google Benchmark",
               "raywalk-bench");
  int threads = 0;
  app.add_option("--threads", threads, "Threads of both Raywalk and OpenCV; 0 = all cores")
      ->check(CLI::Range(0, 1024));
  std::string error_curves;
  app.add_option("--error-curves", error_curves,
                 "Write tables of numerical error into this directory instead of measuring times")
      ->check(CLI::ExistingDirectory);
  std::string device = "cpu";
  app.add_option("--device", device, "Render on cpu, gpu or auto; default cpu");
  bool check = false;
  app.add_flag("--check", check,
               "Run the benchmarks that have a limit; fail where a ratio exceeds it")
      ->excludes("--error-curves");
  app.allow_extras();
  app.callback([&] {
    raywalk::set_thread_count(threads);
    raywalk::choose_device(raywalk::device_from_name(device));
    if (check) {
      if (app.remaining_size() > 0) {
        throw raywalk::UsageError("--check takes no further flags; see --help");
      }
      raywalk::bench::check_ratios();
    } else if (!error_curves.empty()) {
      raywalk::bench::write_model_errors(error_curves);
    } else {
      raywalk::bench::run_benchmarks(argv[0], app.remaining());
    }
  });
  return raywalk::run_program(app, argc, argv);
}
