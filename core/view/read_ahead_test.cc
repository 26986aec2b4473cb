// What is requested from the disk before a block of columns is rendered.
#include "core/view/read_ahead.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr int kWidth = 512;
constexpr std::size_t kRayColumnBytes = std::size_t{3} * kWidth / 2;
constexpr std::size_t kPageBytes = 4096;

SyntheticRoomSpec room_spec() {
  SyntheticRoomSpec spec;
  spec.width = kWidth;
  spec.distance_width = 128;
  spec.overhang_m = 0.25;
  return spec;
}

const TestRoom& test_room() {
  static const TestRoom room(room_spec());
  return room;
}

// The columns from 480 on, of which the second half lies beyond the seam, of a view between four
// lines.
class Block {
 public:
  static constexpr int kFirst = 480;
  static constexpr int kCount = 64;

  Block(const Room& room, Generation generation)
      : renderer_(room, {.generation = generation}), view_(renderer_.prepare({0.1, -0.2})) {}

  std::vector<RaySource> sources(int u) const {
    const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.inputs().output).theta_rad;
    return renderer_.sources(view_.plan().column(theta_rad));
  }
  // Calls check(line, station, u) for every second column and the stations it is read from.
  template <typename Check>
  void for_each_read(const Check& check) const {
    for (int i = 0; i < kCount; i += 2) {
      const int u = (kFirst + i) % kWidth;
      for (const RaySource& source : sources(u)) {
        for (const int next : {0, 1}) check(source.line, source.station + next, u);
      }
    }
  }
  std::vector<RayBytes> bytes_to_fetch() const {
    return ReadAhead(view_.inputs()).bytes_to_fetch(kFirst, kCount, [this](int u) {
      return sources(u);
    });
  }
  void fetch() const {
    ReadAhead(view_.inputs()).fetch(kFirst, kCount, [this](int u) { return sources(u); });
  }

 private:
  Renderer renderer_;
  const PreparedView& view_;
};

class ReadAheadRequests : public testing::TestWithParam<Generation> {
 protected:
  // Whether the middle row of a column is part of what is requested.
  bool requested(int line, int station, int u) const {
    const std::size_t byte =
        static_cast<std::size_t>(u % kWidth) * kRayColumnBytes + kRayColumnBytes / 2;
    return std::ranges::any_of(runs_, [&](const RayBytes& run) {
      return run.line == line && run.station == station && run.begin <= byte && byte < run.end;
    });
  }

  const Block block_{test_room().room(), GetParam()};
  const std::vector<RayBytes> runs_ = block_.bytes_to_fetch();
};

INSTANTIATE_TEST_SUITE_P(Generations, ReadAheadRequests, testing::ValuesIn(kGenerations));

TEST_P(ReadAheadRequests, AreOfTheStationsThatColumnsAreReadFrom) {
  std::set<std::pair<int, int>> read, requested;
  block_.for_each_read([&](int line, int station, int) { read.insert({line, station}); });
  for (const RayBytes& run : runs_) requested.insert({run.line, run.station});
  EXPECT_FALSE(read.empty());
  EXPECT_EQ(requested, read);
}

TEST_P(ReadAheadRequests, HoldTheMiddleOfEveryColumn) {
  int columns = 0;
  block_.for_each_read([&](int line, int station, int u) {
    ++columns;
    EXPECT_TRUE(requested(line, station, u)) << u;
    if (GetParam() != Generation::kInitial) {
      EXPECT_TRUE(requested(line, station, u + kWidth / 4)) << u;
    }
  });
  EXPECT_GE(columns, Block::kCount);
}

TEST_P(ReadAheadRequests, AreRunsOfPagesWithGapsWorthARequest) {
  ASSERT_FALSE(runs_.empty());
  const Room& room = test_room().room();
  const auto begins_a_page = [&](const RayBytes& run, std::size_t byte) {
    const auto* first = room.volume(run.line).column(run.station, 0).data();
    return (reinterpret_cast<std::uintptr_t>(first) + byte) % kPageBytes == 0;
  };
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const RayBytes& run = runs_[i];
    const std::size_t all = room.volume(run.line).columns_and_polar_part(run.station).size();
    EXPECT_LT(run.begin, run.end);
    EXPECT_TRUE(run.begin == 0 || begins_a_page(run, run.begin));
    EXPECT_TRUE(run.end == all || begins_a_page(run, run.end));
    EXPECT_LE(run.end, all);
    if (i == 0) continue;
    const RayBytes& before = runs_[i - 1];
    if (std::pair(before.line, before.station) == std::pair(run.line, run.station)) {
      EXPECT_GT(run.begin, before.end + 4 * kPageBytes);
    } else {
      EXPECT_LT(std::pair(before.line, before.station), std::pair(run.line, run.station));
    }
  }
}

TEST_P(ReadAheadRequests, AreOfThePolarPartWhereColumnsAreCorrected) {
  const bool of_polar_part = std::ranges::any_of(runs_, [](const RayBytes& run) {
    const std::size_t columns = test_room().room().volume(run.line).columns(run.station).size();
    return run.end > columns + kPageBytes;
  });
  EXPECT_EQ(of_polar_part, GetParam() != Generation::kInitial);
}

TEST(ReadAhead, InitialViewRequestsItsColumnsAlone) {
  std::map<std::pair<int, int>, std::size_t> bytes;
  for (const RayBytes& run : Block(test_room().room(), Generation::kInitial).bytes_to_fetch()) {
    bytes[{run.line, run.station}] += run.end - run.begin;
  }
  ASSERT_FALSE(bytes.empty());
  // The block's columns and the one after them, in a run of pages on either side of the seam.
  for (const auto& [place, count] : bytes) {
    EXPECT_LE(count, (Block::kCount + 1) * kRayColumnBytes + 4 * kPageBytes) << place.second;
  }
}

// A room whose rays are dropped from memory, on file systems that do so.
class ColdRoom : public testing::Test {
 protected:
  void SetUp() override {
    for (const Line& line : room_.room().grid().lines) {
      const auto path = line_volume_path(room_.room().directory(), line.id);
      const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
      EXPECT_EQ(::fsync(descriptor), 0);
      EXPECT_EQ(::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED), 0);
      ::close(descriptor);
    }
  }

  // Whether a column of a station comes into memory within two seconds.
  bool arrives(int line, int station, int theta) const {
    const LineVolume& volume = room_.room().volume(line);
    for (int i = 0; i < 200; ++i) {
      if (volume.in_memory(station, theta)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  const TestRoom room_{room_spec()};
};

TEST_F(ColdRoom, ColumnsOfABlockAreFetched) {
  for (const Generation generation : kGenerations) {
    const Block block(room_.room(), generation);
    block.fetch();
    block.for_each_read(
        [&](int line, int station, int u) { EXPECT_TRUE(arrives(line, station, u)) << u; });
  }
}

TEST_F(ColdRoom, PictureIsThatOfARoomInMemory) {
  for (const Generation generation : kGenerations) {
    const cv::Mat cold = room_.image({.generation = generation}, {0.1, -0.2});
    const cv::Mat warm = room_.image({.generation = generation}, {0.1, -0.2});
    EXPECT_EQ(largest_difference(cold, warm), 0.0);
  }
}

}  // namespace
}  // namespace raywalk
