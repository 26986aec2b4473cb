#include "calibrate/poses/contradictions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "calibrate/poses/test_rail_scene.h"

namespace raywalk::calibrate {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kStations = 31;  // of each of four lines, 50 mm apart

// A grid whose stations were solved where they were, on rails laid askew with stations that scatter
// by a third of a millimetre.
struct ListedGrid {
  CaptureSet set = test_grid(kStations);
  FramePoses truth{};

  explicit ListedGrid(unsigned seed)
      : truth(test_truth(set, {.line_m = 0.02, .line_deg = 1.5, .jitter_m = 5e-4}, seed)) {
    for (auto& pose : truth) {
      pose->origin = PoseOrigin::kSolved;
      pose->position_sigma_mm = 0.05;
    }
  }
  std::vector<Contradiction> contradictions() const {
    return contradictions_of(set, truth, fit_rails(set, truth));
  }
  // The list puts the first station where the second is.
  Eigen::Vector3d& listed_m(std::size_t frame) { return set.frames[frame].nominal_m; }
};

std::string text_of(const std::vector<Contradiction>& found) {
  std::string text;
  for (const Contradiction& one : found) text += one.text + "\n";
  return text;
}

TEST(Contradictions, AreNotInvented) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const auto found = ListedGrid(seed).contradictions();
    EXPECT_THAT(found, IsEmpty()) << seed << ": " << text_of(found);
  }
}

TEST(Contradictions, NameExchangedStations) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ListedGrid grid(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::size_t> any(0, grid.set.frames.size() - 1);
    const std::size_t a = any(random);
    std::size_t b = any(random);
    while (b == a) b = any(random);
    std::swap(grid.truth[a], grid.truth[b]);
    const auto found = grid.contradictions();
    ASSERT_EQ(found.size(), 1U) << seed << ": " << text_of(found);
    EXPECT_EQ(found[0].kind, "exchanged");
    EXPECT_THAT(found[0].frames, ElementsAre(std::min(a, b), std::max(a, b)));
    EXPECT_THAT(found[0].text,
                AllOf(HasSubstr(grid.set.frames[a].name), HasSubstr(grid.set.frames[b].name)));
  }
}

// From about six standard deviations of the scatter up.
TEST(Contradictions, NameAStationThatLiesElsewhere) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ListedGrid grid(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::size_t> any(0, grid.set.frames.size() - 1);
    const std::size_t frame = any(random);
    const double off_m = 0.003 * std::pow(1.5, seed);
    const Eigen::Vector3d off = off_m * random_vector(&random, 1.0).normalized();
    grid.truth[frame]->position_m += off;
    const auto found = grid.contradictions();
    ASSERT_EQ(found.size(), 1U) << seed << ": " << text_of(found);
    EXPECT_EQ(found[0].kind, "off");
    EXPECT_THAT(found[0].frames, ElementsAre(frame));
    EXPECT_THAT(found[0].text, HasSubstr(grid.set.frames[frame].name + " lies"));
  }
}

TEST(Contradictions, NameAPictureThatIsMissingOrThereTwice) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ListedGrid grid(seed);
    const int line = static_cast<int>(seed % 4);
    const auto& frames = grid.set.lines[line].frames;
    const std::size_t first = 4 + 2 * seed;
    const bool missing = seed % 2 == 0;
    const FramePoses truth = grid.truth;
    const Eigen::Vector3d step =
        (truth[frames.back()]->position_m - truth[frames.front()]->position_m) / (kStations - 1);
    for (std::size_t i = first; i < frames.size(); ++i) {
      grid.truth[frames[i]]->position_m += missing ? step : Eigen::Vector3d(-step);
    }
    const auto found = grid.contradictions();
    ASSERT_EQ(found.size(), 1U) << seed << ": " << text_of(found);
    EXPECT_EQ(found[0].kind, "shifted");
    EXPECT_EQ(found[0].frames.front(), frames[first]);
    EXPECT_THAT(found[0].text, HasSubstr(missing ? "is missing" : "is there twice"));
  }
}

TEST(Contradictions, NameALineListedTooLongOrTooShort) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ListedGrid grid(seed);
    const double stretch = seed % 2 == 0 ? 1.0 + 0.015 * seed : 1.0 - 0.015 * seed;
    const auto& frames = grid.set.lines[seed % 4].frames;
    const Eigen::Vector3d middle_m = grid.truth[frames[kStations / 2]]->position_m;
    for (const int frame : frames) {
      Eigen::Vector3d& at_m = grid.truth[frame]->position_m;
      at_m = middle_m + stretch * (at_m - middle_m);
    }
    const auto found = grid.contradictions();
    ASSERT_EQ(found.size(), 1U) << seed << ": " << text_of(found);
    EXPECT_EQ(found[0].kind, "stretched");
    EXPECT_THAT(found[0].text, HasSubstr(stretch > 1.0 ? "longer" : "shorter"));
  }
}

// Four stations at 0, 0.01, 1.0 and 2.9 m that the list has at equal steps.
TEST(Contradictions, NameALineThatWasNotTakenAsListed) {
  CaptureSet set = test_line(4, 1.5);
  FramePoses poses = nominal_poses(set);
  const std::array found_m{0.0, 0.01, 1.0, 2.9};
  for (std::size_t i = 0; i < 4; ++i) {
    poses[i]->position_m.x() = found_m[i];
    poses[i]->origin = PoseOrigin::kSolved;
    poses[i]->position_sigma_mm = 1.0;
  }
  const auto found = contradictions_of(set, poses, fit_rails(set, poses));
  ASSERT_EQ(found.size(), 1U) << text_of(found);
  EXPECT_EQ(found[0].kind, "scattered");
  EXPECT_EQ(found[0].frames.size(), 4U);
  EXPECT_THAT(found[0].text, HasSubstr("not where they are listed"));
}

TEST(Contradictions, NeedSolvedPoses) {
  ListedGrid grid(1);
  for (auto& pose : grid.truth) {
    pose->position_m += Eigen::Vector3d(0, 0.1 * (pose->position_m.x() > 0), 0);
    pose->origin = PoseOrigin::kRail;
  }
  EXPECT_THAT(grid.contradictions(), IsEmpty());
}

}  // namespace
}  // namespace raywalk::calibrate
