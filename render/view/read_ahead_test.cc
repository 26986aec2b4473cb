// What is asked of the disk before a block of columns is rendered.
#include "render/view/read_ahead.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <thread>
#include <vector>

#include "render/view/renderer.h"
#include "render/view/test_room.h"

namespace raywalk::render {
namespace {

constexpr PlanPoint kAt{0.1, -0.2};

// A room whose rays are on the disk alone, where the system lets go of them.
class ColdRoom : public testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec spec;
    spec.width = 512;
    spec.distance_width = 128;
    spec.overhang_m = 0.25;
    return spec;
  }

  void SetUp() override {
    for (const Line& line : room_.room().grid().lines) {
      const auto path = line_volume_path(room_.room().directory(), line.id);
      const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
      EXPECT_EQ(::fsync(descriptor), 0);
      EXPECT_EQ(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED), 0);
      ::close(descriptor);
    }
    if (room_.room().volume(0).in_memory(4, 256)) {
      GTEST_SKIP() << "this file system keeps what it is told to drop";
    }
  }

  // Whether a column of a station comes into memory within two seconds.
  bool arrives(const RaySource& source, int next, int theta) const {
    const LineVolume& volume = room_.room().volume(source.line);
    for (int i = 0; i < 200; ++i) {
      if (volume.in_memory(source.station + next, theta)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  TestRoom room_{spec()};
};

TEST_F(ColdRoom, ColumnsOfABlockAreFetched) {
  for (const Generation generation : {Generation::kInitial, Generation::kTwoSided}) {
    Renderer renderer(room_.room(), {.generation = generation});
    const PreparedView& prepared = renderer.prepare(kAt);
    const auto sources_of = [&](int u) {
      const double theta_rad =
          angles_from_pixel({double(u), 0.0}, prepared.inputs().output).theta_rad;
      return renderer.sources(prepared.plan().column(theta_rad));
    };
    // Over the seam.
    constexpr int kFirst = 480;
    constexpr int kCount = 64;
    ReadAhead(prepared.inputs()).fetch(kFirst, kCount, sources_of);
    for (int i = 0; i < kCount; i += 2) {
      const int u = (kFirst + i) % 512;
      for (const RaySource& source : sources_of(u)) {
        for (const int next : {0, 1}) EXPECT_TRUE(arrives(source, next, u)) << u;
      }
    }
  }
  // Of the front line no column was asked for.
  const LineVolume& front = room_.room().volume(1);
  int fetched = 0;
  for (int station = 0; station < front.stations(); ++station) {
    for (int theta = 0; theta < 512; ++theta) fetched += front.in_memory(station, theta) ? 1 : 0;
  }
  EXPECT_LT(fetched, front.stations() * 512 / 2);
}

TEST_F(ColdRoom, PictureIsThatOfARoomInMemory) {
  for (const Generation generation : {Generation::kInitial, Generation::kTwoSided}) {
    const cv::Mat cold = room_.image({.generation = generation}, kAt);
    EXPECT_EQ(largest_difference(cold, room_.image({.generation = generation}, kAt)), 0.0);
  }
}

}  // namespace
}  // namespace raywalk::render
