#include "build_lf/cluster/cluster_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>

#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

ClusterOptions options_of_hall() {
  ClusterOptions options;
  options.frames = "/shared/hall/poses.csv";
  options.room = "/shared/hall.lf";
  options.truth = "/shared/hall/gt.csv";
  options.walk = "/shared/hall/walk.csv";
  options.programs = "/usr/bin";
  return options;
}

// A hall of `side` x `side` cells of 40 stations.
RoomScale hall(int side) {
  RoomScale scale;
  scale.panorama = {4096, 2048};
  scale.lines = 2 * (side + 1);
  scale.stations = scale.lines * side * 40;
  scale.cells = side * side;
  scale.maps = scale.lines * side * 5;
  scale.truth_views = 12;
  scale.walk_views = 600;
  return scale;
}

const ClusterStep& step_of(const ClusterPlan& plan, const std::string& name) {
  const auto found = std::ranges::find(plan.steps, name, &ClusterStep::name);
  if (found == plan.steps.end()) throw std::runtime_error("no step " + name);
  return *found;
}

// What a POSIX shell makes of a word.
std::string word_read_by_shell(const std::string& word) {
  FILE* pipe = popen(("printf %s " + word).c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  pclose(pipe);
  return text;
}

TEST(ClusterPlan, EveryStepComesAfterThoseItNeeds) {
  ClusterOptions options = options_of_hall();
  options.trade = true;
  const ClusterPlan plan = plan_cluster(hall(16), options);
  std::set<std::string> earlier;
  for (const ClusterStep& step : plan.steps) {
    EXPECT_FALSE(step.commands.empty()) << step.name;
    for (const std::string& name : step.after) EXPECT_TRUE(earlier.contains(name)) << step.name;
    EXPECT_EQ(step.after.empty(), step.name == "pack") << step.name;
    EXPECT_TRUE(earlier.insert(step.name).second) << step.name;
  }
  EXPECT_THAT(step_of(plan, "depth-links").after, ElementsAre("pack-merge"));
  EXPECT_THAT(step_of(plan, "depth-sweep").after, ElementsAre("depth-colours-merge"));
  EXPECT_THAT(step_of(plan, "depth-fuse").after, ElementsAre("depth-choose"));
  EXPECT_THAT(step_of(plan, "depth-merge").after, ElementsAre("depth-gains"));
  EXPECT_THAT(step_of(plan, "refine").after, ElementsAre("depth-merge"));
  EXPECT_THAT(step_of(plan, "connect-error").after, ElementsAre("refine-merge"));
  EXPECT_THAT(step_of(plan, "require").after, ElementsAre("connect-error"));
  EXPECT_THAT(step_of(plan, "validate").after, step_of(plan, "path").after);
  EXPECT_TRUE(step_of(plan, "trade").alone);
}

TEST(ClusterPlan, BlocksGrowWithTheRoomAndTakeTheMinutesAskedFor) {
  const ClusterPlan small = plan_cluster(hall(8), options_of_hall());
  const ClusterPlan large = plan_cluster(hall(32), options_of_hall());
  const ClusterStep& sweep = step_of(small, "depth-sweep");
  EXPECT_GT(sweep.commands.size(), 1u);
  EXPECT_GT(step_of(large, "depth-sweep").commands.size(), 3 * sweep.commands.size());
  EXPECT_LE(sweep.minutes, 5.0);
  EXPECT_GT(sweep.minutes, 2.5);

  ClusterOptions quick = options_of_hall();
  quick.rates = parse_rates("depth-sweep=0.28");
  EXPECT_NEAR(
      static_cast<double>(step_of(plan_cluster(hall(32), quick), "depth-sweep").commands.size()),
      0.5 * static_cast<double>(step_of(large, "depth-sweep").commands.size()), 1.0);
}

TEST(ClusterPlan, BlocksAreWhatCanBeToldApart) {
  ClusterOptions options = options_of_hall();
  options.nodes = 5000;
  options.minutes_per_block = 0.001;
  const ClusterPlan plan = plan_cluster(hall(8), options);
  EXPECT_THAT(step_of(plan, "pack").commands, SizeIs(18));
  EXPECT_THAT(step_of(plan, "depth-sweep").commands, SizeIs(720));
  EXPECT_THAT(step_of(plan, "validate").commands, SizeIs(1));
  options.most_blocks = 7;
  EXPECT_THAT(step_of(plan_cluster(hall(8), options), "depth-fuse").commands, SizeIs(7));
}

TEST(ClusterPlan, NamesEveryBlockAndMergesThem) {
  ClusterOptions options = options_of_hall();
  options.nodes = 3;
  const ClusterPlan plan = plan_cluster(hall(4), options);
  const std::string pack =
      "/usr/bin/raywalk-build-lf pack --frames /shared/hall/poses.csv --out /shared/hall.lf "
      "--threads 4";
  EXPECT_THAT(step_of(plan, "pack").commands,
              ElementsAre(pack + " --block 1/3", pack + " --block 2/3", pack + " --block 3/3"));
  EXPECT_THAT(step_of(plan, "pack-merge").commands, ElementsAre(pack + " --merge"));
  EXPECT_THAT(step_of(plan, "validate").commands,
              ElementsAre(HasSubstr("validate /shared/hall-refined.lf --truth /shared/hall/gt.csv "
                                    "--report /shared/hall-validate")));
  EXPECT_THAT(step_of(plan, "path").commands.front(), EndsWith(" --block 1/4"));
}

TEST(ClusterPlan, ASmallRoomNeedsNoBlocks) {
  ClusterOptions options = options_of_hall();
  options.truth.reset();
  options.walk.reset();
  options.minutes_per_block = 1440;
  const ClusterPlan plan = plan_cluster(hall(1), options);
  std::vector<std::string> names;
  for (const ClusterStep& step : plan.steps) {
    names.push_back(step.name);
    EXPECT_THAT(step.commands, ElementsAre(Not(HasSubstr("--block"))));
  }
  EXPECT_THAT(names, ElementsAre("pack", "depth", "refine", "connect-error", "require"));
  options.distances = "/shared/dist";
  EXPECT_THAT(plan_cluster(hall(1), options).steps, SizeIs(4));
}

TEST(ClusterPlan, PathsAndFlagsReachTheProgramsAsTheyAre) {
  ClusterOptions options = options_of_hall();
  options.frames = "/shared/the king's hall/$HOME/poses.csv";
  options.flags["depth"] = "--width 512";
  const ClusterPlan plan = plan_cluster(hall(8), options);
  EXPECT_THAT(step_of(plan, "pack").commands.front(),
              HasSubstr(R"( --frames '/shared/the king'\''s hall/$HOME/poses.csv' )"));
  EXPECT_THAT(step_of(plan, "depth-fuse").commands.front(),
              HasSubstr(" --width 512 --step fuse --block 1/"));
  for (const std::string word :
       {"plain", "", "a b", "it's", "$HOME `id` \"x\" \\ ; * ~ #", "-\t"}) {
    EXPECT_EQ(word_read_by_shell(shell_quoted(word)), word);
  }
}

TEST(ClusterPlan, RefusesWhatCannotBeDone) {
  ClusterOptions options = options_of_hall();
  options.room = "/shared/two\nlines.lf";
  EXPECT_THROW(plan_cluster(hall(1), options), UsageError);
  options = options_of_hall();
  options.truth.reset();
  options.trade = true;
  EXPECT_THROW(plan_cluster(hall(1), options), UsageError);
  options = options_of_hall();
  options.flags["deepth"] = "--width 512";
  EXPECT_THROW(plan_cluster(hall(1), options), UsageError);
  for (const char* rates : {"sweep=1", "pack", "pack=0", "pack=x", "pack=1,,"}) {
    EXPECT_THROW(parse_rates(rates), UsageError) << rates;
  }
}

}  // namespace
}  // namespace raywalk::build_lf
