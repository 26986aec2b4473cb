#include "tests/bench/ratio_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::bench {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::ThrowsMessage;

const std::vector<std::string> kBenchmarks{"bench_view/hlf_vd", "bench_view/initial", "bench_pack"};

RatioLimits read(const std::string& yaml) {
  const TestDirectory directory;
  write_file_atomically(directory / "limits.yaml", yaml);
  return read_ratio_limits(directory / "limits.yaml", kBenchmarks);
}

TEST(RatioLimitsTest, OnlyListedBenchmarksAreLimited) {
  const RatioLimits limits = read("slack: 1.25\nratio:\n  bench_view/initial: 0.5\n");
  EXPECT_EQ(limits.slack, 1.25);
  EXPECT_THAT(limits.largest, ElementsAre(Pair("bench_view/initial", 0.5)));
}

TEST(RatioLimitsTest, WrongFilesAreRefused) {
  const auto refusal = [](const std::string& yaml, const std::string& text) {
    EXPECT_THAT([&] { read(yaml); }, ThrowsMessage<UsageError>(HasSubstr(text))) << yaml;
  };
  refusal("ratio:\n  bench_view/hlf_dv: 2\n", "did you mean 'ratio.bench_view/hlf_vd'?");
  refusal("ratio:\n  bench_pack: fast\n", "'ratio.bench_pack' is 'fast'; it must be a finite");
  refusal("ratio:\n  bench_pack: 0\n", "must lie between");
  refusal("ratio: 3\n", "'ratio' is a group of keys");
  refusal("slack: 0.9\nratio:\n  bench_pack: 2\n", "slack");
  refusal("slack: 1.3\n", "no limits");
  EXPECT_THROW(read_ratio_limits("/nowhere/limits.yaml", kBenchmarks), UsageError);
}

TEST(RatioLimitsTest, ARatioMayReachItsLimitTimesTheSlack) {
  const RatioLimits limits{.slack = 1.5,
                           .largest = {{"bench_pack", 2.0}, {"bench_view/initial", 0.5}}};
  EXPECT_THAT(exceeded_limits(limits, {{"bench_pack", 3.0}, {"bench_view/initial", 0.1}}),
              ElementsAre());
  EXPECT_THAT(exceeded_limits(limits, {{"bench_pack", 3.01}, {"bench_view/initial", 0.1}}),
              ElementsAre("bench_pack"));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(exceeded_limits(limits, {{"bench_pack", kNan}, {"bench_view/initial", 0.8}}),
              ElementsAre("bench_pack", "bench_view/initial"));
}

TEST(RatioLimitsTest, EveryLimitIsALineOfTheTable) {
  const RatioLimits limits{.slack = 1.5,
                           .largest = {{"bench_pack", 2.0}, {"bench_view/initial", 0.5}}};
  const std::string table = ratio_table(
      limits, {{"bench_pack", 3.25}, {"bench_view/initial", 0.125}, {"bench_view/hlf_vd", 9.0}});
  EXPECT_EQ(table,
            "bench_pack                     3.250  limit   3.000  exceeded\n"
            "bench_view/initial             0.125  limit   0.750  ok\n");
}

TEST(RatioLimitsTest, ALimitedBenchmarkWithoutRatioIsAnError) {
  const RatioLimits limits{.slack = 1.0, .largest = {{"bench_pack", 2.0}}};
  EXPECT_THAT(
      [&] {
        exceeded_limits(limits, {{"bench_view/hlf_vd", 1.0}});
      },
      ThrowsMessage<Error>(HasSubstr("bench_pack has reported no ratio")));
}

}  // namespace
}  // namespace raywalk::bench
