#include "tests/bench/check_ratios.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <vector>

#include "core/base/error.h"
#include "tests/bench/ratio_limits.h"

namespace raywalk::bench {
namespace {

constexpr int kTries = 3;

// Gathers names or ratios instead of printing them.
class Gathering : public benchmark::BenchmarkReporter {
 public:
  Gathering() { SetOutputStream(&names_); }

  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const auto ratio = run.counters.find("ratio");
      if (ratio == run.counters.end()) continue;
      const std::string& arguments = run.run_name.args;
      ratios_[run.run_name.function_name + (arguments.empty() ? "" : "/" + arguments)] =
          ratio->second.value;
    }
  }

  // What --benchmark_list_tests has printed, a name a line.
  std::string names() const { return names_.str(); }
  const Ratios& ratios() const { return ratios_; }

 private:
  std::ostringstream names_;
  Ratios ratios_;
};

void set_flag(std::string program, std::string flag) {
  std::array<char*, 2> arguments{program.data(), flag.data()};
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
}

// Without what follows the name of a benchmark and its arguments ("/iterations:12/manual_time").
std::vector<std::string> names_of_benchmarks(const std::string& program) {
  Gathering listed;
  set_flag(program, "--benchmark_list_tests=true");
  benchmark::RunSpecifiedBenchmarks(&listed);
  set_flag(program, "--benchmark_list_tests=false");
  std::vector<std::string> names;
  std::istringstream lines(listed.names());
  for (std::string line; std::getline(lines, line);) {
    names.push_back(line.substr(0, line.find("/iterations:")));
  }
  return names;
}

void measure(const std::vector<std::string>& names, Ratios* least) {
  Gathering measured;
  benchmark::RunSpecifiedBenchmarks(&measured,
                                    fmt::format("^({})/iterations:", fmt::join(names, "|")));
  for (const auto& [name, ratio] : measured.ratios()) {
    const auto [known, is_new] = least->try_emplace(name, ratio);
    if (!is_new) known->second = std::min(known->second, ratio);
  }
}

}  // namespace

void check_ratios(const std::string& program, const std::filesystem::path& limits_file) {
  const RatioLimits limits = read_ratio_limits(limits_file, names_of_benchmarks(program));
  std::vector<std::string> names;
  for (const auto& limit : limits.largest) names.push_back(limit.first);
  Ratios measured;
  for (int i = 0; i < kTries && !names.empty(); ++i) {
    measure(names, &measured);
    names = exceeded_limits(limits, measured);
  }
  fmt::print("{}", ratio_table(limits, measured));
  if (!names.empty()) {
    throw Error(
        fmt::format("{} of {} ratios exceed their limits", names.size(), limits.largest.size()));
  }
}

}  // namespace raywalk::bench
