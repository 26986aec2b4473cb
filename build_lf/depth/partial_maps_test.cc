#include "build_lf/depth/partial_maps.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/depth/file_memory.h"
#include "build_lf/pack/station_data.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr PanoramaSize kPartialSize{8, 4};
constexpr StationIndex kStation{1, 5};
const Eigen::Vector3d kPosition_m(1.0, 2.0, 3.0);

InverseDistanceMap map_of(float first) {
  InverseDistanceMap map{kStation, kPosition_m, kPartialSize, {}, {}};
  for (int i = 0; i < kPartialSize.width * kPartialSize.height; ++i) {
    map.inverse.push_back(first + 0.125f * static_cast<float>(i));
    map.confidence.push_back(static_cast<std::uint8_t>(7 * i));
  }
  return map;
}

class PartialMapsTest : public ::testing::Test {
 protected:
  fs::path room() const { return directory_.path(); }
  fs::path partial() const { return directory_ / "distances.partial"; }
  fs::path distances() const { return directory_ / "distances" / "estimated"; }

  static std::optional<InverseDistanceMap> load(const PartialMaps& maps,
                                                const std::string& stage = "swept") {
    return maps.load(stage, kStation);
  }
  // A room whose distances are `text`.
  void give_distances(const std::string& text) const {
    fs::create_directories(distances());
    write_file_atomically(distances() / "x0.h5", text);
  }
  fs::path stored_file() const {
    for (const auto& entry : fs::directory_iterator(partial())) {
      if (entry.path().extension() == ".map") return entry.path();
    }
    return {};
  }

  TestDirectory directory_;
};

TEST_F(PartialMapsTest, ReturnsWhatWasStored) {
  PartialMaps maps(room(), "inputs");
  EXPECT_FALSE(load(maps).has_value());
  const InverseDistanceMap stored = map_of(0.0f);
  maps.store("swept", stored);
  const auto loaded = load(maps);
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(loaded->station, kStation);
  EXPECT_EQ(loaded->position_m, kPosition_m);
  EXPECT_EQ(loaded->size, kPartialSize);
  EXPECT_EQ(loaded->inverse, stored.inverse);
  EXPECT_EQ(loaded->confidence, stored.confidence);
  // Stages and stations are separate.
  EXPECT_FALSE(load(maps, "final").has_value());
  EXPECT_FALSE(maps.load("swept", {5, 1}).has_value());
}

TEST_F(PartialMapsTest, TheSameRunResumesWithTheLastMaps) {
  {
    PartialMaps maps(room(), "inputs");
    maps.store("swept", map_of(0.0f));
    maps.store("swept", map_of(3.0f));
  }
  EXPECT_EQ(load(PartialMaps(room(), "inputs"))->inverse.front(), 3.0f);
}

TEST_F(PartialMapsTest, OtherInputsStartOver) {
  {
    PartialMaps maps(room(), "inputs");
    maps.store("swept", map_of(0.0f));
    write_file_atomically(maps.volumes() / "x0.h5", "half a room");
  }
  const PartialMaps other(room(), "other inputs");
  EXPECT_FALSE(load(other).has_value());
  EXPECT_TRUE(fs::is_empty(other.volumes()));
}

// A run killed before it recorded its inputs may have left anything.
TEST_F(PartialMapsTest, MapsOfUnknownInputsAreNotTrusted) {
  { PartialMaps(room(), "inputs").store("swept", map_of(0.0f)); }
  fs::remove(partial() / "inputs.sha256");
  EXPECT_FALSE(load(PartialMaps(room(), "inputs")).has_value());
}

TEST_F(PartialMapsTest, DamagedMapsCountAsMissing) {
  PartialMaps maps(room(), "inputs");
  maps.store("swept", map_of(0.0f));
  const fs::path file = stored_file();
  const std::string whole = read_file(file);
  for (const size_t at : {size_t{0}, size_t{3}, whole.size() / 2, whole.size() - 1}) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 1);
    write_file_atomically(file, flipped);
    EXPECT_FALSE(load(maps).has_value()) << at;
  }
  for (const size_t length : {size_t{0}, size_t{1}, whole.size() - 1}) {
    write_file_atomically(file, whole.substr(0, length));
    EXPECT_FALSE(load(maps).has_value()) << length;
  }
  write_file_atomically(file, whole + "x");
  EXPECT_FALSE(load(maps).has_value());
  write_file_atomically(file, whole);
  EXPECT_TRUE(load(maps).has_value());
}

TEST_F(PartialMapsTest, ConcurrentRunsAreRejected) {
  const PartialMaps maps(room(), "inputs");
  EXPECT_THAT(error_of([&] { PartialMaps(room(), "inputs"); }),
              HasSubstr("another raywalk-build-lf"));
}

TEST_F(PartialMapsTest, CompletingReplacesTheDistancesAndCleansUp) {
  for (const bool replaced : {false, true}) {
    if (replaced) give_distances("old");
    if (replaced) write_file_atomically(distances() / "x9.h5", "of a line that has none now");
    PartialMaps maps(room(), "inputs");
    maps.store("final", map_of(0.0f));
    write_file_atomically(maps.volumes() / "x0.h5", "estimated");
    if (replaced) {
      EXPECT_EQ(read_file(distances() / "x0.h5"), "old");
    }
    maps.complete();
    EXPECT_EQ(read_file(distances() / "x0.h5"), "estimated");
    EXPECT_FALSE(fs::exists(distances() / "x9.h5"));
    EXPECT_EQ(directory_.entries(), 1U);
  }
}

class StoredMapsTest : public ::testing::Test {
 protected:
  static SyntheticRoomSpec spec() {
    SyntheticRoomSpec tiny = room_of_scale(1.0);
    tiny.width = 32;
    return tiny;
  }
  // Line z0 gets no maps.
  static DepthPlan plan_without_z0(const Room& room) {
    DepthPlan plan = plan_depth(room, {.every = 8});
    std::erase_if(plan.maps, [](const SweepReference& map) { return map.station.line == 2; });
    return plan;
  }
  void store_maps(PartialMaps* partial) const {
    for (const SweepReference& reference : plan_.maps) {
      InverseDistanceMap map = true_map(spec().scene, reference.position_m, plan_.size);
      map.station = reference.station;
      map.inverse[3] = 0.0f;
      map.confidence[5] = static_cast<std::uint8_t>(10 * reference.station.station);
      partial->store(kFinalStage, map);
    }
  }

  // Without contradictions.
  void write_all(const PartialMaps& partial) const {
    const LineSearch none = [](int) { return Contradictions(); };
    write_volumes(room_.room(), DepthMethod::kSweep, plan_, partial, {0, 4}, none);
  }

  DepthTestRoom room_{spec()};
  DepthPlan plan_ = plan_without_z0(room_.room());
};

TEST_F(StoredMapsTest, AreReadBackAsTheRoomsDistances) {
  PartialMaps partial(room_.room().directory(), "inputs");
  store_maps(&partial);
  write_all(partial);
  partial.complete();
  use_distances(room_.room().directory(), DistanceKind::kEstimated);
  const Room room = Room::open(room_.room().directory());
  EXPECT_EQ(room.distances(2).maps(), 0);
  const DistanceVolume& distances = room.distances(0);
  EXPECT_THAT(distances.stations(), ::testing::ElementsAre(0, 8, 16));
  EXPECT_EQ(distances.size(), plan_.size);
  EXPECT_FALSE(distances.given());
  const InverseDistanceMap truth =
      true_map(spec().scene, room.grid().lines[0].stations[8].position_m, plan_.size);
  const StationDistances stored = stored_distances(distances, 1);
  ASSERT_EQ(stored.distance_m.size(), truth.inverse.size());
  for (size_t pixel = 0; pixel < truth.inverse.size(); ++pixel) {
    const float inverse = pixel == 3 ? 0.0f : truth.inverse[pixel];
    ASSERT_EQ(stored.distance_m[pixel], 1.0f / inverse);
  }
  EXPECT_EQ(stored.confidence[5], 80);
  EXPECT_EQ(stored.confidence[6], 255);
}

TEST_F(StoredMapsTest, DamagedMapIsNamedAndItsLineNotWritten) {
  PartialMaps partial(room_.room().directory(), "inputs");
  store_maps(&partial);
  for (const auto& entry : fs::directory_iterator(partial.volumes().parent_path())) {
    if (entry.path().filename() == "final-0-8.map") std::ofstream(entry.path()) << "damaged";
  }
  EXPECT_THAT(error_of([&] { write_all(partial); }), HasSubstr("run the command again"));
  EXPECT_TRUE(fs::is_empty(partial.volumes()));
}

TEST(FileMemoryTest, HoldsValuesAndLeavesNoFiles) {
  const TestDirectory directory;
  FileMemory memory(directory.path());
  {
    std::pmr::vector<std::uint64_t> values(1'000'003, &memory);
    EXPECT_EQ(std::accumulate(values.begin(), values.end(), std::uint64_t{0}), 0U);
    std::iota(values.begin(), values.end(), std::uint64_t{7});
    std::pmr::vector<std::uint16_t> others(&memory);
    for (int i = 0; i < 5000; ++i) others.push_back(static_cast<std::uint16_t>(i));
    const auto moved = std::move(values);
    for (std::size_t i = 0; i < moved.size(); i += 997) ASSERT_EQ(moved[i], i + 7);
    for (std::size_t i = 0; i < others.size(); ++i) ASSERT_EQ(others[i], i);
    EXPECT_TRUE(fs::is_empty(directory.path())) << "while in use";
  }
  EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST(FileMemoryTest, NamesTheDirectoryThatCannotHoldTheValues) {
  const TestDirectory directory;
  const fs::path missing = directory.path() / "missing";
  FileMemory memory(missing);
  EXPECT_THAT(error_of([&] { const std::pmr::vector<int> values(1000, &memory); }),
              ::testing::AllOf(HasSubstr(missing.string() + ": cannot write there"),
                               HasSubstr("No such file")));
}

// As on a full disk: the blocks cannot be had. Without reserving them, writing would end the test.
TEST(FileMemoryTest, ReportsAFullDisk) {
  const TestDirectory directory;
  FileMemory memory(directory.path());
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1 << 20, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error =
      error_of([&] { const std::pmr::vector<char> values(2 << 20, &memory); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(error, directory.path().string() +
                       ": cannot hold 2 MB of intermediate values: File too large");
  const std::pmr::vector<char> values(2 << 20, &memory);
  EXPECT_EQ(values.back(), 0);
}

}  // namespace
}  // namespace raywalk::build_lf
