#include "build_lf/depth/station_gains.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "build_lf/depth/depth_test_room.h"
#include "core/base/parallel.h"

namespace raywalk::build_lf {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

StationGains gains_of(const Room& room) {
  return solve_gains(room.grid(), measure_links(room, pairs_to_compare(room.grid())));
}

// Exposure of every station and channel.
using Exposures = std::vector<std::vector<cv::Vec3d>>;

Exposures equal_exposures(const Grid& grid) {
  Exposures exposures;
  for (const Line& line : grid.lines) {
    exposures.emplace_back(line.stations.size(), cv::Vec3d(1, 1, 1));
  }
  return exposures;
}

// Multiplies red, green and blue of frames.
DepthTestRoom::Edit expose(const Exposures& exposures) {
  return [&exposures](StationIndex station, cv::Mat* frame) {
    const cv::Vec3d& rgb =
        exposures[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)];
    cv::multiply(*frame, cv::Scalar(rgb[2], rgb[1], rgb[0]), *frame);
  };
}

// The largest deviation of log(gain * exposure) from its mean, over the stations selected by
// `counts`.
double largest_error(const StationGains& gains, const Exposures& exposures,
                     const std::function<bool(StationIndex)>& counts = nullptr) {
  double largest = 0.0;
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<double> logs;
    for (size_t line = 0; line < exposures.size(); ++line) {
      for (size_t i = 0; i < exposures[line].size(); ++i) {
        if (counts && !counts({static_cast<int>(line), static_cast<int>(i)})) continue;
        logs.push_back(std::log(gains.gain[line][i][channel] * exposures[line][i][channel]));
      }
    }
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / double(logs.size());
    for (const double value : logs) largest = std::max(largest, std::fabs(value - mean));
  }
  return largest;
}

// Where the exposure of a line changes most.
struct Step {
  int to = 0;
  double factor = 1.0;
};
Step largest_step(const std::vector<ColourGain>& gains) {
  Step largest;
  for (int i = 1; i < static_cast<int>(gains.size()); ++i) {
    const double step = log_exposure_step(gains, i);
    if (std::fabs(step) > std::fabs(std::log(largest.factor))) largest = {i, std::exp(step)};
  }
  return largest;
}

class StationGainsOfScale : public ::testing::TestWithParam<double> {};

TEST_P(StationGainsOfScale, AreOneWhereTheExposureIsConstant) {
  const DepthTestRoom room(room_of_scale(GetParam()));
  const StationGains gains = gains_of(room.room());
  EXPECT_LT(largest_error(gains, equal_exposures(room.grid())), 0.005);
  ASSERT_THAT(gains.gain, SizeIs(4));
  for (const auto& line : gains.gain) EXPECT_NEAR(largest_step(line).factor, 1.0, 0.005);
}

TEST_P(StationGainsOfScale, FollowADriftingExposure) {
  const SyntheticRoomSpec spec = room_of_scale(GetParam(), 7);
  Exposures exposures = equal_exposures(synthetic_grid(spec));
  std::mt19937 random(3);
  std::normal_distribution<double> log_exposure(0.0, 0.03);
  for (auto& line : exposures) {
    for (cv::Vec3d& station : line) {
      for (int c = 0; c < 3; ++c) station[c] = std::exp(log_exposure(random));
    }
  }
  const DepthTestRoom room(spec, expose(exposures));
  EXPECT_LT(largest_error(gains_of(room.room()), exposures), 0.01);
}

INSTANTIATE_TEST_SUITE_P(CellSides, StationGainsOfScale, ::testing::Values(0.2, 1.0, 5.0));

TEST(StationGainsTest, FollowAJumpInNoise) {
  const SyntheticRoomSpec spec = room_of_scale(1.0, 4);
  Exposures exposures = equal_exposures(synthetic_grid(spec));
  for (size_t i = 9; i < exposures[2].size(); ++i) exposures[2][i] *= 1.3;
  const auto exposed = expose(exposures);
  const DepthTestRoom room(spec, [&](StationIndex station, cv::Mat* frame) {
    exposed(station, frame);
    add_noise(station, 3.0, frame);
  });
  const StationGains gains = gains_of(room.room());
  EXPECT_LT(largest_error(gains, exposures), 0.01);
  EXPECT_EQ(largest_step(gains.gain[2]).to, 9);
  EXPECT_NEAR(largest_step(gains.gain[2]).factor, 1.3, 0.013);
  EXPECT_NEAR(largest_step(gains.gain[0]).factor, 1.0, 0.005);
}

TEST(StationGainsTest, AreRobustToAMisplacedFrame) {
  const SyntheticRoomSpec spec = room_of_scale(1.0);
  const DepthTestRoom room(spec, [](StationIndex station, cv::Mat* frame) {
    if (station == StationIndex{1, 9}) {
      *frame = render_scene(room_of_scale(1.0, 99).scene, {0.3, 0.2, -0.4}, frame->cols, 0.5);
    }
  });
  const auto others = [](StationIndex station) { return station != StationIndex{1, 9}; };
  EXPECT_LT(largest_error(gains_of(room.room()), equal_exposures(room.grid()), others), 0.01);
}

TEST(StationGainsTest, DoNotDependOnTheNumberOfThreads) {
  const DepthTestRoom room(room_of_scale(1.0));
  set_thread_count(1);
  const auto alone = gains_of(room.room()).gain;
  set_thread_count(0);
  EXPECT_EQ(gains_of(room.room()).gain, alone);
}

TEST(StationGainsTest, OfBlackFramesAreOne) {
  const DepthTestRoom room(room_of_scale(1.0), [](StationIndex station, cv::Mat* frame) {
    if (station.line == 3 && station.station < 2) frame->setTo(cv::Scalar(0, 0, 0));
  });
  const StationGains gains = gains_of(room.room());
  EXPECT_EQ(gains.gain[3][0], ColourGain(1, 1, 1));
  EXPECT_EQ(gains.gain[3][1], ColourGain(1, 1, 1));
  EXPECT_LT(largest_error(gains, equal_exposures(room.grid())), 0.005);
}

// ---- From synthetic links

Grid grid_of_lines(const std::vector<int>& stations) {
  Grid grid;
  for (const int count : stations) {
    Line line;
    for (int i = 0; i < count; ++i) {
      line.stations.push_back({.file = "", .position_m = {double(i), 0, 0}, .along_m = double(i)});
    }
    grid.lines.push_back(line);
  }
  return grid;
}

StationLink link_between(StationIndex from, StationIndex to, double log_ratio) {
  return {.pair = {from, to},
          .comparable = true,
          .log_ratio = {log_ratio, log_ratio, log_ratio},
          .log_ratio_error = {1e-3, 1e-3, 1e-3}};
}

TEST(SolveGainsTest, SplitsOneStepEvenlyOverItsTwoSides) {
  // The second station is e^0.2 times brighter.
  const StationGains gains =
      solve_gains(grid_of_lines({2}), std::vector{link_between({0, 0}, {0, 1}, 0.2)});
  EXPECT_NEAR(std::log(gains.gain[0][0][1]), 0.1, 1e-6);
  EXPECT_NEAR(std::log(gains.gain[0][1][1]), -0.1, 1e-6);
  EXPECT_NEAR(log_exposure_step(gains.gain[0], 1), 0.2, 1e-6);
}

TEST(SolveGainsTest, EachConnectedPartHasAMeanOfOne) {
  const StationGains gains =
      solve_gains(grid_of_lines({3, 2, 1}),
                  std::vector{link_between({0, 0}, {0, 1}, 0.3), link_between({0, 1}, {0, 2}, 0.3),
                              link_between({1, 0}, {1, 1}, -0.1)});
  EXPECT_NEAR(std::log(gains.gain[0][0][0]), 0.3, 1e-6);
  EXPECT_NEAR(std::log(gains.gain[0][1][0]), 0.0, 1e-6);
  EXPECT_NEAR(std::log(gains.gain[1][0][0]), -0.05, 1e-6);
  EXPECT_EQ(gains.gain[2][0], ColourGain(1, 1, 1));
}

TEST(SolveGainsTest, IsRobustToAGrossOutlier) {
  const int stations = 30;
  for (const double wrong : {0.1, 1.0, 3.0}) {
    std::vector<StationLink> links;
    for (int i = 0; i < stations; ++i) {
      for (int j = i + 1; j < std::min(i + 3, stations); ++j) {
        links.push_back(link_between({0, i}, {0, j}, i == 12 && j == 13 ? wrong : 0.0));
      }
    }
    const StationGains gains = solve_gains(grid_of_lines({stations}), links);
    for (const ColourGain& gain : gains.gain[0]) EXPECT_NEAR(gain[0], 1.0, 0.005) << wrong;
  }
}

TEST(SolveGainsTest, IsStableOverAThousandStations) {
  const int stations = 1000;
  std::vector<StationLink> links;
  for (int i = 0; i + 1 < stations; ++i) {
    links.push_back(link_between({0, i}, {0, i + 1}, i % 2 == 0 ? 0.2 : -0.2));
  }
  const StationGains gains = solve_gains(grid_of_lines({stations}), links);
  EXPECT_NEAR(std::log(gains.gain[0].front()[2]), 0.1, 1e-5);
  EXPECT_NEAR(std::log(gains.gain[0].back()[2]), -0.1, 1e-5);
}

}  // namespace
}  // namespace raywalk::build_lf
