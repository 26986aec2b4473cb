// End-to-end test of parts of raywalk-build-lf depth, which a cluster may start twice.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "build_lf/depth/depth_test_files.h"
#include "tests/end_to_end/background_process.h"
#include "tests/end_to_end/depth_command.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Two copies of a room: one for a single run, one for parts.
class DepthPartCommandTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec = furnished_room(96);
    spec.spacing_m = 0.125;
    return spec;
  }

  DepthPartCommandTest() {
    fs::copy(room_.room().directory(), parts_, fs::copy_options::recursive);
  }

  BackgroundProcess start(const std::string& step, const std::string& part,
                          const std::string& log) const {
    return {{RAYWALK_BUILD_LF, "depth", parts_.string(), "--every", "3", "--threads", "1", "--step",
             step, "--part", part},
            directory_ / log};
  }

  std::string log(const std::string& name) const { return read_file(directory_ / name); }

  // Two processes at the same part.
  void make_twice_at_a_time(const std::string& step, const std::string& part) const {
    BackgroundProcess first = start(step, part, "first");
    BackgroundProcess second = start(step, part, "second");
    EXPECT_EQ(first.wait(), 0) << step << " " << part << ": " << log("first");
    EXPECT_EQ(second.wait(), 0) << step << " " << part << ": " << log("second");
  }

  void wait_for_swept_map() const {
    constexpr auto kLongest = std::chrono::seconds(20);
    const auto end = std::chrono::steady_clock::now() + kLongest;
    while (std::chrono::steady_clock::now() < end) {
      for (const auto& entry : fs::directory_iterator(parts_ / "distances.partial")) {
        if (entry.path().filename().string().starts_with("swept-")) return;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "no map was made";
  }

  // A process stands still with some of its maps made while another makes the whole part.
  void sweep_beside_one_that_stands(const std::string& part) const {
    BackgroundProcess standing = start("sweep", part, "standing");
    wait_for_swept_map();
    standing.signal(SIGSTOP);
    BackgroundProcess other = start("sweep", part, "other");
    EXPECT_EQ(other.wait(), 0) << log("other");
    standing.signal(SIGCONT);
    EXPECT_EQ(standing.wait(), 0) << log("standing");
  }

  void expect_result_of_one_run() const {
    const CommandResult finished =
        run_command(fmt::format("{} depth {} --every 3", RAYWALK_BUILD_LF, parts_.string()));
    ASSERT_EQ(finished.exit_code, 0) << finished.errors;
    const CommandResult plain = depth(room_.room(), "--every 3");
    ASSERT_EQ(plain.exit_code, 0) << plain.errors;
    EXPECT_EQ(result_files_of(parts_), result_files_of(room_.room().directory()));
    EXPECT_FALSE(fs::exists(parts_ / "distances.partial"));
  }

  DepthTestRoom room_{spec()};
  TestDirectory directory_;
  fs::path parts_ = directory_ / "parts.lf";
};

TEST_F(DepthPartCommandTest, TwoProcessesAtAPartLeaveTheRoomOfOneRun) {
  EXPECT_EQ(run_command(fmt::format("{} depth {} --every 3 --step prepare", RAYWALK_BUILD_LF,
                                    parts_.string()))
                .exit_code,
            0);
  for (const std::string step : {"sweep", "choose", "fuse", "volumes"}) {
    if (step == "sweep") {
      sweep_beside_one_that_stands("1/2");
    } else {
      make_twice_at_a_time(step, "1/2");
    }
    make_twice_at_a_time(step, "2/2");
  }
  expect_result_of_one_run();
}

}  // namespace
}  // namespace raywalk::build_lf
