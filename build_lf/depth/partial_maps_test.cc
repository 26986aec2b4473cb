#include "build_lf/depth/partial_maps.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
namespace fs = std::filesystem;

constexpr PanoramaSize kPartialSize{8, 4};
constexpr StationIndex kStation{1, 5};
const Eigen::Vector3d kPosition_m(1.0, 2.0, 3.0);

InverseDistanceMap map_of(float first) {
  InverseDistanceMap map{kStation, kPosition_m, kPartialSize, {}, {}};
  for (int i = 0; i < kPartialSize.width * kPartialSize.height; ++i) {
    map.omega.push_back(first + 0.125f * static_cast<float>(i));
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
  EXPECT_EQ(loaded->omega, stored.omega);
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
  EXPECT_EQ(load(PartialMaps(room(), "inputs"))->omega.front(), 3.0f);
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

// The lock works between processes.
TEST_F(PartialMapsTest, ConcurrentRunsAreRejected) {
  const PartialMaps maps(room(), "inputs");
  const pid_t child = fork();
  if (child == 0) {
    try {
      const PartialMaps second(room(), "inputs");
      _exit(0);
    } catch (const Error& e) {
      _exit(std::string(e.what()).find("another raywalk-build-lf") != std::string::npos ? 1 : 2);
    }
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

TEST_F(PartialMapsTest, ARoomThatCannotBeWrittenIsNamed) {
  // A file in place of the directory is unwritable even for root.
  std::ofstream(partial()) << "in the way";
  EXPECT_THAT([&] { PartialMaps(room(), "inputs"); },
              ThrowsMessage<Error>(HasSubstr("distances.partial")));
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

}  // namespace
}  // namespace raywalk::build_lf
