#include "tests/bench/ratio_limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/files/settings.h"

namespace raywalk::bench {
namespace {

constexpr double kLeastRatio = 0.001;
constexpr double kLargestRatio = 1e6;
constexpr double kMostSlack = 10.0;

double ratio_of(const std::string& benchmark, const Ratios& measured) {
  const auto found = measured.find(benchmark);
  if (found == measured.end()) {
    throw Error(fmt::format("{} has reported no ratio, so it cannot be limited", benchmark));
  }
  return found->second;
}

}  // namespace

RatioLimits read_ratio_limits(const std::filesystem::path& file,
                              const std::vector<std::string>& benchmarks) {
  RatioLimits limits;
  Ratios listed;
  SettingsSchema schema;
  schema.number("slack", &limits.slack, 1.0, kMostSlack);
  for (const std::string& name : benchmarks) {
    schema.number("ratio." + name, &listed[name], kLeastRatio, kLargestRatio);
  }
  schema.load(file);
  for (const auto& [name, ratio] : listed) {
    if (ratio > 0.0) limits.largest[name] = ratio;
  }
  if (limits.largest.empty()) {
    throw UsageError(file.string() + ": no limits; list benchmarks under 'ratio'");
  }
  return limits;
}

std::vector<std::string> exceeded_limits(const RatioLimits& limits, const Ratios& measured) {
  std::vector<std::string> exceeded;
  for (const auto& [name, largest] : limits.largest) {
    if (!(ratio_of(name, measured) <= largest * limits.slack)) exceeded.push_back(name);
  }
  return exceeded;
}

std::string ratio_table(const RatioLimits& limits, const Ratios& measured) {
  const std::vector<std::string> exceeded = exceeded_limits(limits, measured);
  std::string table;
  for (const auto& [name, largest] : limits.largest) {
    const bool ok = std::find(exceeded.begin(), exceeded.end(), name) == exceeded.end();
    table += fmt::format("{:<28} {:>7.3f}  limit {:>7.3f}  {}\n", name, measured.at(name),
                         largest * limits.slack, ok ? "ok" : "exceeded");
  }
  return table;
}

}  // namespace raywalk::bench
