#include "build_lf/exposure/room_gains.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "build_lf/depth/depth_test_room.h"
#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/gain_significance.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/exposure/patch_ratios.h"
#include "build_lf/exposure/surface_maps.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/files/atomic_output.h"
#include "core/view/test_room.h"

namespace raywalk::build_lf {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

// Factors of the levels of a frame, by station, channel (red, green, blue) and u / width.
using Exposure = std::function<cv::Vec3d(StationIndex, double)>;

SyntheticRoomSpec small_room() {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.spacing_m = 1.0 / 3.0;
  return spec;
}

DepthTestRoom::Edit exposed(const Exposure& exposure) {
  return [exposure](StationIndex station, cv::Mat* frame) {
    for (int u = 0; u < frame->cols; ++u) {
      const cv::Vec3d rgb = exposure(station, (u + 0.5) / frame->cols);
      for (int v = 0; v < frame->rows; ++v) {
        auto& bgr = frame->at<cv::Vec3b>(v, u);
        for (int c = 0; c < 3; ++c) bgr[2 - c] = cv::saturate_cast<uchar>(bgr[2 - c] * rgb[c]);
      }
    }
  };
}

// A random factor of about exp(+-0.12), the same for equal `where`.
double random_exposure(StationIndex station, int where) {
  cv::RNG random(static_cast<std::uint64_t>(7919 * (100 * station.line + station.station) +
                                            104729 * where + 17));
  random.next();
  return std::exp(0.7 * std::clamp(random.gaussian(0.12), -0.3, 0.3) - 0.1);
}

cv::Vec3d equally(double factor) { return {factor, factor, factor}; }

Exposure by_station() {
  return [](StationIndex s, double) {
    return cv::Vec3d(random_exposure(s, 0), random_exposure(s, 1), random_exposure(s, 2));
  };
}

Exposure by_quarter() {
  return [](StationIndex s, double share) {
    return equally(random_exposure(s, 10 + static_cast<int>(4.0 * share)));
  };
}

// Exact maps of every n-th station.
SurfaceMaps exact_maps(const DepthTestRoom& room, int every = 1) {
  SurfaceMaps maps{.size = room.room().panorama(), .stations = {}, .read = {}};
  for (const StationIndex station : all_stations(room.grid())) {
    if (station.station % every == 0) maps.stations.push_back(station);
  }
  maps.read = [&room, size = maps.size](StationIndex station) {
    return true_map(small_room().scene, room.grid().station(station).position_m, size);
  };
  return maps;
}

GainFields gains_of(const DepthTestRoom& room, const SurfaceMaps& maps) {
  return solve_room_gains(room.room(), maps);
}
GainFields gains_of(const DepthTestRoom& room) { return gains_of(room, exact_maps(room)); }

void expect_all_one(const GainFields& fields) {
  for (const auto& line : fields) {
    for (const GainField& field : line) EXPECT_TRUE(is_one(field)) << field.whole;
  }
}

cv::Vec3d gain_at(const GainField& field, int theta, int phi) {
  cv::Vec3d gain(field.whole);
  if (field.local.empty()) return gain;
  return gain.mul(cv::Vec3d(field.local.at<cv::Vec3f>(theta, phi)));
}

// Root mean square of log(gain * exposure) less the channel's mean, in percent. Patches at the
// borders of quarters belong to both, and those at the poles are hardly seen.
double error_percent(const GainFields& fields, const Grid& grid, const Exposure& exposure) {
  double square = 0.0;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> logs;
    for (const StationIndex station : all_stations(grid)) {
      for (int theta = 0; theta < kPatchesTheta; ++theta) {
        if (theta % 8 == 0 || theta % 8 == 7) continue;
        const double level = exposure(station, (theta + 0.5) / kPatchesTheta)[c];
        for (int phi = 3; phi < kPatchesPhi - 3; ++phi) {
          logs.push_back(std::log(gain_at(gain_field(fields, station), theta, phi)[c] * level));
        }
      }
    }
    const auto count = static_cast<double>(logs.size());
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / count;
    for (const double value : logs) square += (value - mean) * (value - mean) / (3.0 * count);
  }
  return 100.0 * std::sqrt(square);
}

TEST(RoomGainsTest, AreExactlyOneWherePicturesAgree) {
  for (const double noise : {0.0, 4.0}) {
    const DepthTestRoom room(small_room(), [noise](StationIndex station, cv::Mat* frame) {
      add_noise(station, noise, frame);
    });
    expect_all_one(gains_of(room));
  }
}

TEST(RoomGainsTest, UndoExposuresOfStations) {
  const DepthTestRoom room(small_room(), exposed(by_station()));
  const GainFields fields = gains_of(room);
  EXPECT_GT(error_percent(unit_gain_fields(room.grid()), room.grid(), by_station()), 6.0);
  EXPECT_LT(error_percent(fields, room.grid(), by_station()), 1.0);
  for (const StationIndex s : all_stations(room.grid())) {
    EXPECT_TRUE(gain_field(fields, s).local.empty());
  }
}

TEST(RoomGainsTest, UndoExposuresOfPartsOfThePicture) {
  const DepthTestRoom room(small_room(), exposed(by_quarter()));
  EXPECT_GT(error_percent(unit_gain_fields(room.grid()), room.grid(), by_quarter()), 6.0);
  EXPECT_LT(error_percent(gains_of(room), room.grid(), by_quarter()), 2.0);
}

TEST(RoomGainsTest, UndoAnExposureInOnePartOfOneStation) {
  const Exposure one = [](StationIndex s, double share) {
    return equally(s == StationIndex{1, 2} && share < 0.25 ? 0.8 : 1.0);
  };
  const DepthTestRoom room(small_room(), exposed(one));
  const GainFields fields = gains_of(room);
  EXPECT_NEAR(gain_at(gain_field(fields, {1, 2}), 4, 8)[1], 1.25, 0.04);
  EXPECT_NEAR(gain_at(gain_field(fields, {1, 2}), 20, 8)[1], 1.0, 0.02);
  EXPECT_TRUE(is_one(gain_field(fields, {3, 3})));
}

TEST(RoomGainsTest, NeedMapsOfOnlySomeStations) {
  const DepthTestRoom room(small_room(), exposed(by_quarter()));
  EXPECT_LT(error_percent(gains_of(room, exact_maps(room, 2)), room.grid(), by_quarter()), 2.5);
}

// A factor of 1.6 clips a quarter of the levels of the scene, and a factor of 0.2 blackens many.
TEST(RoomGainsTest, IgnoreClippedAndBlackPixels) {
  const Exposure extremes = [](StationIndex s, double) {
    return equally(s.station == 1 ? 1.6 : s.station == 3 ? 0.2 : 1.0);
  };
  const DepthTestRoom room(small_room(), exposed(extremes));
  EXPECT_LT(error_percent(gains_of(room), room.grid(), extremes), 2.0);
}

// The dolly below is masked: its levels, which differ from station to station, do not count.
TEST(RoomGainsTest, IgnoreMaskedPixels) {
  const auto dolly = [](StationIndex station, cv::Mat* frame) {
    frame->rowRange(frame->rows / 2, frame->rows) = equally(60.0 + 25.0 * station.station);
  };
  const int width = small_room().width;
  cv::Mat valid(width / 2, width, CV_8UC1, cv::Scalar(255));
  valid.rowRange(valid.rows / 2, valid.rows) = 0;
  const DepthTestRoom masked(small_room(), dolly, [&](StationIndex) { return valid; });
  const DepthTestRoom unmasked(small_room(), dolly);
  SurfaceMaps maps = exact_maps(unmasked);
  maps.valid = valid;  // of all pictures
  expect_all_one(gains_of(masked));
  expect_all_one(gains_of(unmasked, maps));
}

// People stand elsewhere in every frame.
TEST(RoomGainsTest, WithstandPeopleWhoWalkOn) {
  const DepthTestRoom room(small_room(), [](StationIndex station, cv::Mat* frame) {
    const int u = (37 * station.station + 53 * station.line) % 110;
    cv::rectangle(*frame, {u, 24}, {u + 8, 48}, cv::Scalar(20, 60, 200), cv::FILLED);
  });
  const Exposure none = [](StationIndex, double) { return equally(1.0); };
  EXPECT_LT(error_percent(gains_of(room), room.grid(), none), 3.0);
}

TEST(RoomGainsTest, WithstandGrosslyWrongDistances) {
  const DepthTestRoom room(small_room(), exposed(by_station()));
  SurfaceMaps maps = exact_maps(room);
  maps.read = [exact = maps.read](StationIndex station) {
    InverseDistanceMap map = exact(station);
    cv::RNG random(static_cast<std::uint64_t>(station.station + 10 * station.line + 1));
    for (float& inverse : map.inverse) {
      if (random.uniform(0, 4) == 0) inverse = random.uniform(0.0F, 3.0F);
    }
    return map;
  };
  EXPECT_LT(error_percent(gains_of(room, maps), room.grid(), by_station()), 1.5);
}

TEST(RoomGainsTest, AreOneForAStationThatSharesNothing) {
  const Exposure exposure = [](StationIndex s, double) {
    return equally(s == StationIndex{2, 3} ? 0.0 : random_exposure(s, 0));
  };
  const DepthTestRoom room(small_room(), exposed(exposure));
  const GainFields fields = gains_of(room);
  EXPECT_TRUE(is_one(gain_field(fields, {2, 3})));
  EXPECT_NEAR(gain_at(gain_field(fields, {2, 2}), 8, 8)[0] * exposure({2, 2}, 0.0)[0],
              gain_at(gain_field(fields, {0, 1}), 8, 8)[0] * exposure({0, 1}, 0.0)[0], 0.02);
}

TEST(RoomGainsTest, AreOneWithoutDistances) {
  const DepthTestRoom room(small_room(), exposed(by_station()));
  SurfaceMaps maps = exact_maps(room);
  maps.stations.clear();
  expect_all_one(gains_of(room, maps));
}

// Solved for in several windows, gains are nearly those of all stations at once.
TEST(RoomGainsTest, WindowsAgreeWithTheWholeRoom) {
  const DepthTestRoom room(small_room(), exposed(by_quarter()));
  const SurfaceMaps maps = exact_maps(room);
  const auto stations = all_stations(room.grid());
  const GainFields whole = gains_of(room, maps);
  const GainFields parts = solve_room_gains(room.room(), maps, int(stations.size()) / 4);
  for (const StationIndex s : stations) {
    for (int theta = 0; theta < kPatchesTheta; ++theta) {
      const cv::Vec3d expected = gain_at(gain_field(whole, s), theta, kPatchesPhi / 2);
      const cv::Vec3d gain = gain_at(gain_field(parts, s), theta, kPatchesPhi / 2);
      EXPECT_NEAR(gain[1] / expected[1], 1.0, 0.02) << s.line << "/" << s.station;
    }
  }
}

TEST(RoomGainsTest, DoNotDependOnTheNumberOfThreads) {
  const DepthTestRoom room(small_room(), exposed(by_quarter()));
  const SurfaceMaps maps = exact_maps(room);
  set_thread_count(1);
  const GainFields alone = gains_of(room, maps);
  set_thread_count(0);
  const GainFields together = gains_of(room, maps);
  for (const StationIndex s : all_stations(room.grid())) {
    EXPECT_EQ(gain_field(alone, s).whole, gain_field(together, s).whole);
    EXPECT_EQ(cv::norm(gain_field(alone, s).local, gain_field(together, s).local, cv::NORM_INF),
              0.0);
  }
}

SyntheticRoomSpec line_with_maps(int distance_width) {
  SyntheticRoomSpec spec = line_of_scale(1.0);
  spec.spacing_m = 0.5;
  spec.width = 512;
  spec.distance_width = distance_width;
  spec.distance_every = 2;
  return spec;
}

TEST(SurfaceMapsTest, AreThoseOfTheRoomReduced) {
  const SyntheticRoomSpec spec = line_with_maps(512);
  const TestRoom room(spec);
  const SurfaceMaps maps = surface_maps_of(room.room());
  EXPECT_EQ(maps.size, (PanoramaSize{kSurfaceWidth, kSurfaceWidth / 2}));
  ASSERT_THAT(maps.stations, ::testing::ElementsAre(StationIndex{0, 0}, StationIndex{0, 2}));
  const InverseDistanceMap map = maps.read({0, 2});
  const InverseDistanceMap truth = true_map(spec.scene, map.position_m, maps.size);
  EXPECT_EQ(map.position_m, room.room().grid().lines[0].stations[2].position_m);
  EXPECT_GT(share_within(map, truth, 0.01), 0.98);
}

TEST(SurfaceMapsTest, AreNotWiderThanStored) {
  EXPECT_EQ(surface_maps_of(TestRoom(line_with_maps(64)).room()).size, (PanoramaSize{64, 32}));
}

TEST(SurfaceMapsTest, AreUnknownWhereNotReliable) {
  SyntheticRoomSpec spec = line_with_maps(512);
  spec.stored_confidence = [](int u, int) { return u < 256 ? kMinConfidence - 1 : kMinConfidence; };
  const TestRoom room(spec);
  const SurfaceMaps maps = surface_maps_of(room.room());
  const InverseDistanceMap map = maps.read({0, 0});
  for (int theta = 0; theta < maps.size.width; ++theta) {
    EXPECT_EQ(map.confidence[pixel_index(theta, 20, maps.size)] > 0, theta >= 128) << theta;
  }
}

// --- What gains are solved from, and how they are stored with a room -----------------------------

// Ratios between neighbours and next neighbours of pictures with these log gains.
std::vector<GainEquation> chain(const std::vector<double>& gains, double error) {
  std::vector<GainEquation> equations;
  const int count = static_cast<int>(gains.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < std::min(i + 3, count); ++j) {
      const double difference = gains[i] - gains[j];
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
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(found[i], gains[i], 1e-6);
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
    EXPECT_NEAR(found[i], gains[i] - mean, 0.03) << i;
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
  GainFields stored() const { return Room::open(room_).gains(); }

  TestDirectory directory_;
  fs::path room_ = directory_ / "room.lf";
};

TEST_F(MakeGainsTest, AreStoredWithTheRoom) {
  write(0.8);
  const GainsSummary summary = make_gains(room_);
  EXPECT_EQ(summary.stations, 12);
  EXPECT_EQ(summary.local, 0);
  EXPECT_NEAR(summary.largest, std::pow(0.8, -0.75), 0.02);  // the mean of the logarithms is 0
  EXPECT_THAT(text_of(summary), HasSubstr("gains to 12 of 12 stations, 0 of them locally"));
  const GainFields gains = stored();
  ASSERT_FALSE(gains.empty());
  make_gains(room_);
  for (const StationIndex station : all_stations(Room::open(room_).grid())) {
    EXPECT_EQ(gain_field(stored(), station).whole, gain_field(gains, station).whole) << "again";
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(gains[3][i].whole[1] / gains[0][i].whole[1], 1.25, 0.02);
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
  EXPECT_THAT(stored(), IsEmpty());
}

TEST_F(MakeGainsTest, TakeThePlaceOfDamagedOnes) {
  write(0.8);
  make_gains(room_);
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_THROW(Room::open(room_), Error);
  make_gains(room_);
  EXPECT_FALSE(stored().empty());
  std::ofstream(gains_path(room_)) << "not HDF5";
  EXPECT_TRUE(remove_gains(room_));
  EXPECT_THAT(stored(), IsEmpty());
}

TEST_F(MakeGainsTest, NeedDistances) {
  write(0.8, false);
  EXPECT_THAT([&] { make_gains(room_); },
              ::testing::ThrowsMessage<Error>(HasSubstr("raywalk-build-lf depth")));
  EXPECT_FALSE(has_file());
}

}  // namespace
}  // namespace raywalk::build_lf
