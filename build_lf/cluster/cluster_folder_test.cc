#include "build_lf/cluster/cluster_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// A cell of four lines with a station at every quarter, its corners on the lines along x, and a
// program that notes what it is called with, all in a folder with a name that is hard to quote.
class ClusterFolderTest : public testing::Test {
 protected:
  ClusterFolderTest() {
    fs::create_directory(base_);
    std::ofstream list(base_ / "poses.csv");
    list << "file,x,y,z\n";
    int count = 0;
    const auto add = [&](double x, double z) {
      list << fmt::format("p{}.png,{},0,{}\n", count++, x, z);
    };
    for (const double at : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      add(at, 0.0);
      add(at, 1.0);
      if (at > 0.0 && at < 1.0) {
        add(0.0, at);
        add(1.0, at);
      }
    }
    write_image(base_ / "p0.png", cv::Mat(32, 64, CV_8UC3, cv::Scalar::all(9)));
    add_program("raywalk-build-lf", "");
    add_program("raywalk-render", "");
    options_.frames = base_ / "poses.csv";
    options_.room = base_ / "room.lf";
    options_.out = base_ / "jobs";
    options_.programs = base_;
    options_.nodes = 2;
  }

  void add_program(const std::string& name, const std::string& first) const {
    std::ofstream(base_ / name) << "#!/bin/sh\n" << first << "\necho \"$*\" >>\"$0.calls\"\n";
    fs::permissions(base_ / name, fs::perms::owner_all);
  }

  ClusterPlan plan() const {
    return plan_cluster(scale_of(options_.frames, {}, std::nullopt, std::nullopt), options_);
  }

  // The exit code of a script of the folder.
  int run(const std::string& script) const {
    ::setenv("RAYWALK_PLAN", options_.out.c_str(), 1);
    const int status = std::system(("\"$RAYWALK_PLAN\"/" + script + " >/dev/null 2>&1").c_str());
    return WEXITSTATUS(status);
  }

  TestDirectory folder_;
  fs::path base_ = folder_ / "the king's \"$hall";
  ClusterOptions options_;
};

TEST_F(ClusterFolderTest, ScaleIsThatOfTheList) {
  const RoomScale scale = scale_of(options_.frames, {}, std::nullopt, std::nullopt);
  EXPECT_EQ(scale.stations, 16);
  EXPECT_EQ(scale.lines, 4);
  EXPECT_EQ(scale.cells, 1);
  EXPECT_GT(scale.maps, 8);
  EXPECT_LE(scale.maps, 16);
  EXPECT_EQ(scale.panorama.width, 64);
  EXPECT_THROW(scale_of("-", {}, std::nullopt, std::nullopt), UsageError);
}

TEST_F(ClusterFolderTest, ScriptsDoEveryCommandOnceAndNameWhatIsMissing) {
  const ClusterPlan plan = this->plan();
  write_cluster_folder(plan, options_);
  EXPECT_THAT(read_file(options_.out / "slurm/depth-sweep.sbatch"),
              AllOf(HasSubstr("#SBATCH --array=1-2\n"), HasSubstr("#SBATCH --requeue\n"),
                    HasSubstr("\nexec ./slurm-task.sh depth-sweep \"$SLURM_ARRAY_TASK_ID\"\n")));
  EXPECT_EQ(run("finish.sh"), 1);
  EXPECT_THAT(read_file(options_.out / "missing.txt"),
              HasSubstr("pack: 2 of 2 missing: 1-2 (logs/pack-1.log)\n"));

  add_program("raywalk-render", "exit 1");
  int failed = 0;
  for (const ClusterStep& step : plan.steps) {
    for (size_t i = 1; i <= step.commands.size(); ++i) {
      const int status = run(fmt::format("task.sh {} {}", step.name, i));
      EXPECT_EQ(status, step.name == "connect-error" ? 1 : 0) << step.name;
      failed += status;
    }
  }
  EXPECT_EQ(failed, 1);
  EXPECT_EQ(run("finish.sh"), 1);
  EXPECT_EQ(read_file(options_.out / "missing.txt"),
            "connect-error: 1 of 1 missing: 1 (logs/connect-error-1.log)\n");

  add_program("raywalk-render", "");
  EXPECT_EQ(run("task.sh connect-error 1"), 0);
  EXPECT_EQ(run("task.sh pack 1"), 0);  // done before
  EXPECT_EQ(run("finish.sh"), 0);
  EXPECT_EQ(run("task.sh pack 3"), 2);
  const std::string frames = "--frames " + options_.frames.string();
  const std::string pack = "pack " + frames + " --out " + options_.room.string() + " --threads 4";
  EXPECT_THAT(
      read_file(base_ / "raywalk-build-lf.calls"),
      testing::StartsWith(pack + " --block 1/2\n" + pack + " --block 2/2\n" + pack + " --merge\n"));
}

TEST_F(ClusterFolderTest, FinishMergesWhatHasItsBlocks) {
  write_cluster_folder(plan(), options_);
  EXPECT_EQ(run("task.sh pack 1"), 0);
  EXPECT_EQ(run("finish.sh"), 1);
  EXPECT_FALSE(fs::exists(options_.out / "state/done/pack-merge/1"));
  EXPECT_EQ(run("task.sh pack 2"), 0);
  EXPECT_EQ(run("finish.sh"), 1);
  EXPECT_TRUE(fs::exists(options_.out / "state/done/pack-merge/1"));
}

TEST_F(ClusterFolderTest, ReplacesNothingButAPlan) {
  write_cluster_folder(plan(), options_);
  EXPECT_THROW(write_cluster_folder(plan(), options_), Error);
  options_.replace = true;
  EXPECT_EQ(run("task.sh pack 1"), 0);
  write_cluster_folder(plan(), options_);
  EXPECT_FALSE(fs::exists(options_.out / "state"));
  std::ofstream(options_.out / "notes.txt") << "mine";
  EXPECT_THROW(write_cluster_folder(plan(), options_), Error);
}

}  // namespace
}  // namespace raywalk::build_lf
