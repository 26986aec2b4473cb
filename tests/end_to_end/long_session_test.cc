// Ten thousand stations in one run, in simulated time, to detect memory growth per station.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "capture/run/capture_sequence.h"
#include "capture/run/fake_camera.h"
#include "capture/session/session_database.h"
#include "capture/session/session_status.h"
#include "capture/session/test_session.h"
#include "core/files/test_support.h"
#include "simulator/rig/test_slider.h"

namespace raywalk::capture {
namespace {

constexpr int kLines = 8;
constexpr int kStationsOfLine = 1250;

// proc(5): the second number of statm is the resident set, in pages.
double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double total_pages = 0.0, resident_pages = 0.0;
  statm >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

TEST(LongSession, MemoryStaysFlatOverTenThousandStations) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer keeps freed memory";
#endif
  // In memory, where syncing is free: the test measures memory, not the disk.
  if (std::filesystem::exists("/dev/shm")) setenv("TMPDIR", "/dev/shm", 1);
  const TestDirectory directory;
  TestCapture capture{.directory = directory / "session"};
  capture.plan = {};
  for (int i = 0; i < kLines; ++i) {
    capture.plan.lines.push_back(
        test_line("x" + std::to_string(i), LineAxis::kX, 0.1 * i, 0.0, 0.001, kStationsOfLine));
  }
  TestSlider slider({}, &capture.clock);
  FakeCamera camera(&capture.clock);
  double early_mb = 0.0;
  camera.on_shot = [&] {
    if (camera.shots() == kStationsOfLine) early_mb = resident_mb();
  };
  {
    const auto session = capture.open();
    Carriage carriage(slider.driver(), &capture.clock, SoftLimits(0.0, 2000.0), {.poll_ms = 50.0});
    CaptureSequence({&carriage, &camera, session.get(), [](auto&&...) {}, &capture.clock}, {})
        .run(capture.plan);
    EXPECT_LT(resident_mb() - early_mb, 8.0);
  }
  SessionReader reader(capture.directory);
  EXPECT_EQ(session_status(&reader)["captured"], kLines * kStationsOfLine);
}

}  // namespace
}  // namespace raywalk::capture
