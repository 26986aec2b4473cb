// The largest ratios of time that benchmarks may report, as a YAML file lists them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace raywalk::bench {

// Ratios by the name of their benchmark ("bench_view/hlf_vd").
using Ratios = std::map<std::string, double>;

struct RatioLimits {
  double slack = 1.0;  // every limit is multiplied by it, 1 to 10
  Ratios largest{};    // above 0, not empty
};

// Reads keys `slack` and `ratio.<name>`, where a name is one of `benchmarks`. Throws UsageError:
// what SettingsSchema refuses, an unknown benchmark among it; a file that sets no limit.
RatioLimits read_ratio_limits(const std::filesystem::path& file,
                              const std::vector<std::string>& benchmarks);

// The benchmarks whose measured ratio exceeds its limit times the slack, by name. One that has a
// limit but was not measured throws Error.
std::vector<std::string> exceeded_limits(const RatioLimits& limits, const Ratios& measured);

// A line for every limit: name, ratio, limit times slack, "ok" or "exceeded". Throws as
// exceeded_limits does.
std::string ratio_table(const RatioLimits& limits, const Ratios& measured);

}  // namespace raywalk::bench
