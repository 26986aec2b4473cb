#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/bench/bench_room.h"

namespace raywalk::bench {
namespace {

using Ratios = std::map<std::string, double>;  // by the name of their benchmark

// The largest ratio of a benchmark's time to that of a plain program for the same view in the same
// run (render_plainly), on a machine with 2 cores. cv::remap of the same size is no yardstick: on
// one and the same machine a view took 2.6 to 15 times as long, as remap waits for memory in
// another way.
const Ratios kLimits = {
    {"bench_view/initial", 0.02},
    {"bench_view/hlf_vd", 0.18},
    {"bench_view/two_sided", 0.25},
    {"bench_fast/hlf_vd", 0.14},
    {"bench_fast/two_sided", 0.145},
    {"bench_flat/initial", 0.033},
    {"bench_flat/hlf_vd", 0.13},
    {"bench_flat/two_sided", 0.13},
    // To one view of one eye.
    {"bench_stereo/hlf_vd", 1.75},
    {"bench_stereo/two_sided", 1.75},
};
// Every limit is multiplied by it, as the ratios of shared machines vary.
constexpr double kSlack = 1.5;
constexpr int kTries = 3;

// Keeps the least ratios instead of printing them.
class Gathering : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const auto ratio = run.counters.find("checked");
      if (ratio == run.counters.end()) continue;
      const auto [known, is_new] =
          least_.try_emplace(run.run_name.function_name, ratio->second.value);
      if (!is_new) known->second = std::min<double>(known->second, ratio->second.value);
    }
  }

  double ratio(const std::string& name) const {
    const auto found = least_.find(name);
    if (found == least_.end())
      throw Error(name + " has reported no ratio, so it cannot be limited");
    return found->second;
  }
  bool exceeded(const std::string& name) const {
    return !(ratio(name) <= kSlack * kLimits.at(name));
  }

 private:
  Ratios least_;
};

}  // namespace

void check_ratios() {
  std::vector<std::string> names;
  for (const auto& limit : kLimits) names.push_back(limit.first);
  Gathering measured;
  for (int i = 0; i < kTries && !names.empty(); ++i) {
    benchmark::RunSpecifiedBenchmarks(&measured,
                                      fmt::format("^({})/iterations:", fmt::join(names, "|")));
    std::erase_if(names, [&](const std::string& name) { return !measured.exceeded(name); });
  }
  for (const auto& [name, limit] : kLimits) {
    fmt::print("{:<28} {:>7.3f}  limit {:>7.3f}  {}\n", name, measured.ratio(name), kSlack * limit,
               measured.exceeded(name) ? "exceeded" : "ok");
  }
  if (!names.empty()) {
    throw Error(fmt::format("{} of {} ratios exceed their limits", names.size(), kLimits.size()));
  }
}

}  // namespace raywalk::bench
