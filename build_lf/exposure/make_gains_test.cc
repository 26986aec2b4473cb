#include "build_lf/exposure/make_gains.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <vector>

#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/gain_significance.h"
#include "build_lf/exposure/patch_ratios.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/test_directory.h"
#include "core/room/room.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;
namespace fs = std::filesystem;

// Ratios between neighbours and next neighbours of pictures with these log gains.
std::vector<GainEquation> chain(const std::vector<double>& gains, double error) {
  std::vector<GainEquation> equations;
  const int count = static_cast<int>(gains.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < std::min(i + 3, count); ++j) {
      const double difference =
          gains[static_cast<std::size_t>(i)] - gains[static_cast<std::size_t>(j)];
      equations.push_back({i, j, difference, error});
    }
  }
  return equations;
}

// In all channels `whole` everywhere, and `local` more in the first half of theta and less in the
// second.
PatchGains patches_of(double whole, double local) {
  PatchGains patches = PatchGains::Constant(whole + local);
  patches.bottomRows(kPatches / 2).setConstant(whole - local);
  return patches;
}

// The same gains, where the halves of the ratios agree or disagree about them.
TEST(GainSignificanceTest, UncertainAndUnmeasuredGainsAreDropped) {
  const auto keeps = [](double black, double white, bool is_measured) {
    std::array<bool, kPatches> measured{};
    measured.fill(is_measured);
    const PatchGains gains = patches_of(0.0, 0.1);
    const std::array halves{patches_of(0.0, black), patches_of(0.0, white)};
    return keep_significant(gains, halves, measured).patches.has_value();
  };
  EXPECT_TRUE(keeps(0.11, 0.09, true));
  EXPECT_FALSE(keeps(0.2, 0.0, true));
  EXPECT_FALSE(keeps(0.11, 0.09, false));
}

// A chair below covers many of the narrow patches there.
TEST(GainSpotsTest, WhatStandsBelowVanishes) {
  Eigen::VectorXd chair = Eigen::VectorXd::Zero(kPatches);
  for (int theta = 10; theta <= 15; ++theta) {
    chair.segment(theta * kPatchesPhi + kPatchesPhi - 2, 2).setConstant(0.3);
  }
  EXPECT_TRUE(without_spots(chair).isZero(0.0));
}

TEST(GainGraph, ExactRatiosGiveTheGainsUpToTheirMean) {
  const std::vector<double> gains = {0.3, -0.1, 0.02, 0.0, -0.22};  // mean 0
  const Eigen::VectorXd found = solve_gain_graph(chain(gains, 0.01), 5);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(found[i], gains[static_cast<std::size_t>(i)], 1e-6);
}

TEST(GainGraph, EveryPartHasAMeanOfZero) {
  // 0 - 1 and 2 - 3 - 4; 5 alone.
  const std::vector<GainEquation> equations = {
      {0, 1, 0.4, 0.1}, {2, 3, 0.3, 0.01}, {3, 4, 0.3, 2.0}};
  const Eigen::VectorXd found = solve_gain_graph(equations, 6);
  EXPECT_NEAR(found[0], 0.2, 1e-6);
  EXPECT_NEAR(found[1], -0.2, 1e-6);
  EXPECT_NEAR(found[2] + found[3] + found[4], 0.0, 1e-6);
  EXPECT_NEAR(found[2] - found[4], 0.6, 1e-4);
  EXPECT_EQ(found[5], 0.0);
}

TEST(GainGraph, IsRobustToAnOutlier) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 0.005);
  std::vector<double> gains(30);
  double mean = 0.0;
  for (double& gain : gains) mean += (gain = 10.0 * normal(random)) / 30.0;
  std::vector<GainEquation> equations = chain(gains, 0.005);
  for (GainEquation& equation : equations) equation.difference += normal(random);
  equations[20].difference += 3.0;
  const Eigen::VectorXd found = solve_gain_graph(equations, 30);
  for (int i = 0; i < 30; ++i) {
    EXPECT_NEAR(found[i], gains[static_cast<std::size_t>(i)] - mean, 0.03) << i;
  }
}

TEST(GainGraph, ExtremeErrorsStayFinite) {
  for (const double error : {1e-3, 1.0, 1e3}) {
    const Eigen::VectorXd found = solve_gain_graph({{0, 1, 0.5, error}, {1, 2, -0.5, 1.0}}, 3);
    EXPECT_TRUE(found.allFinite()) << error;
    EXPECT_NEAR(found[0] - found[1], 0.5, 2e-3) << error;
  }
  EXPECT_EQ(solve_gain_graph({}, 0).size(), 0);
}

class MakeGainsTest : public ::testing::Test {
 protected:
  void write(double gain_of_z1, bool distances = true) {
    SyntheticRoomSpec spec;
    spec.spacing_m = 0.5;
    spec.distances = distances;
    spec.line_gain["z1"] = gain_of_z1;
    write_synthetic_room(spec, room_);
  }

  bool has_file() const { return fs::exists(gains_path(room_)); }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(MakeGainsTest, AreStoredWithTheRoom) {
  write(0.8);
  const GainsSummary summary = make_gains(room_);
  EXPECT_EQ(summary.stations, 12);
  EXPECT_EQ(summary.local, 0);
  EXPECT_NEAR(summary.largest, std::pow(0.8, -0.75), 0.02);  // the mean of the logarithms is 0
  const Room room = Room::open(room_);
  ASSERT_FALSE(room.gains().empty());
  for (int station = 0; station < 3; ++station) {
    const auto i = static_cast<size_t>(station);
    EXPECT_NEAR(room.gains()[3][i].whole[1] / room.gains()[0][i].whole[1], 1.25, 0.02);
  }
  EXPECT_THAT(text_of(summary), HasSubstr("gains to 12 of 12 stations, 0 of them locally"));
}

TEST_F(MakeGainsTest, AreTheSameWhenSolvedAgain) {
  write(0.8);
  make_gains(room_);
  const GainFields before = Room::open(room_).gains();
  make_gains(room_);
  const GainFields after = Room::open(room_).gains();
  for (std::size_t line = 0; line < before.size(); ++line) {
    for (std::size_t i = 0; i < before[line].size(); ++i) {
      EXPECT_EQ(after[line][i].whole, before[line][i].whole);
    }
  }
  EXPECT_TRUE(read_manifest(room_).gains);
}

TEST_F(MakeGainsTest, LeaveNoTraceInARoomThatNeedsNone) {
  write(1.0);
  const std::string manifest = read_file(manifest_path(room_));
  const GainsSummary summary = make_gains(room_);
  EXPECT_EQ(summary.corrected, 0);
  EXPECT_THAT(text_of(summary), HasSubstr("need no gains"));
  EXPECT_FALSE(has_file());
  EXPECT_EQ(read_file(manifest_path(room_)), manifest);
}

TEST_F(MakeGainsTest, CanBeRemoved) {
  write(0.8);
  EXPECT_FALSE(remove_gains(room_));
  make_gains(room_);
  EXPECT_TRUE(remove_gains(room_));
  EXPECT_FALSE(has_file());
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
}

TEST_F(MakeGainsTest, TakeThePlaceOfDamagedOnes) {
  write(0.8);
  make_gains(room_);
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_THROW(Room::open(room_), Error);
  make_gains(room_);
  EXPECT_FALSE(Room::open(room_).gains().empty());
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_TRUE(remove_gains(room_));
  EXPECT_THAT(Room::open(room_).gains(), IsEmpty());
}

TEST_F(MakeGainsTest, NeedDistances) {
  write(0.8, false);
  EXPECT_THAT([&] { make_gains(room_); },
              ThrowsMessage<Error>(HasSubstr("raywalk-build-lf depth")));
  EXPECT_FALSE(has_file());
}

}  // namespace
}  // namespace raywalk::build_lf
