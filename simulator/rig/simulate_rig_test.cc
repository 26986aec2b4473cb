#include "simulator/rig/simulate_rig.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "capture/base/clock.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/files/file_lock.h"
#include "core/files/test_directory.h"
#include "simulator/rig/test_rig.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSliderMap = RAYWALK_CONFIGS "/sliders/generic.yaml";

void require(bool condition, const char* what) {
  if (condition) return;
  std::cerr << what << '\n';
  std::_Exit(1);
}

void wait_for(const fs::path& file) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!fs::exists(file)) {
    require(std::chrono::steady_clock::now() < deadline, "the rig is not ready");
    SystemClock().sleep(duration_from_ms(5.0));
  }
}

void check_notice(const fs::path& file) {
  const auto notice = nlohmann::json::parse(read_file(file));
  require(notice.at("pid") == getpid(), "wrong pid");
  require(fs::exists(notice.at("slider").get<std::string>()), "no slider");
  require(notice.at("modbus_port").get<int>() > 0, "no port");
  require(notice.at("camera_url").get<std::string>().starts_with("http://127.0.0.1:"), "no camera");
}

// Starts a rig and stops it again; exits with 42 if its files are as expected.
void run_until_stopped() {
  const TestDirectory directory;
  const fs::path out = directory / "rig";
  install_interrupt_handlers();
  const std::jthread visitor([&out] {
    wait_for(out / "rig.json");
    check_notice(out / "rig.json");
    kill(getpid(), SIGTERM);
  });
  simulate_rig(small_rig(directory.path(), kSliderMap), out);
  require(!fs::exists(out / "rig.json"), "rig.json is left behind");
  require(!fs::exists(fs::symlink_status(out / "slider")), "slider is left behind");
  require(fs::exists(out / "truth/true_poses.csv"), "no truth");
  std::_Exit(42);
}

// The stop request cannot be reset, so it is made in a separate process.
TEST(SimulateRigDeathTest, PublishesItsAddressesUntilStopped) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(run_until_stopped(), ::testing::ExitedWithCode(42), "");
}

TEST(SimulateRigTest, DirectoryOfAnotherRigIsRefused) {
  const TestDirectory directory;
  const RigConfig config = small_rig(directory.path(), kSliderMap);
  const FileLock other(directory / "rig.lock", "busy");
  EXPECT_THROW(simulate_rig(config, directory.path()), Error);
}

}  // namespace
}  // namespace raywalk::capture
