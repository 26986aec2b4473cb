#include "build_lf/depth/contradictions.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "build_lf/depth/depth_test_room.h"

namespace raywalk::build_lf {
namespace {

using testing::IsEmpty;

constexpr StationIndex kVisited{0, 8};   // the station that sees a person
const cv::Rect kPerson(60, 30, 12, 30);  // in its frame of 128 x 64

SyntheticRoomSpec plain_room() { return room_of_scale(1.0); }

// Paints a person of one colour into the frames of the given stations.
DepthTestRoom::Edit person_in(std::vector<StationIndex> stations, double noise = 0.0) {
  return [stations, noise](StationIndex station, cv::Mat* frame) {
    if (std::ranges::find(stations, station) != stations.end()) {
      (*frame)(kPerson) = cv::Scalar(20, 30, 240);
    }
    if (noise > 0.0) add_noise(station, noise, frame);
  };
}

// Of all lines.
Contradictions find_contradictions(const Room& room, const DepthPlan& plan, const GainFields& gains,
                                   const FinalMap& final_map) {
  const LineSearch search = contradiction_search(room, plan, gains, final_map);
  Contradictions all;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    Contradictions of_line = search(line);
    all.size = of_line.size;
    std::ranges::move(of_line.stations, std::back_inserter(all.stations));
  }
  return all;
}

class ContradictionsTest : public testing::Test {
 protected:
  // With exact maps at every `every`-th station, edited by `edit`.
  static Contradictions contradictions_of(
      const DepthTestRoom& room, int every = 2,
      const std::function<void(InverseDistanceMap*)>& edit = nullptr) {
    const DepthPlan plan = plan_depth(room.room(), {.every = every});
    return find_contradictions(room.room(), plan, unit_gain_fields(room.grid()),
                               [&](StationIndex station) {
                                 InverseDistanceMap map = exact_map(room, station, plan.size);
                                 if (edit) edit(&map);
                                 return map;
                               });
  }
  static InverseDistanceMap exact_map(const DepthTestRoom& room, StationIndex station,
                                      PanoramaSize size) {
    const Eigen::Vector3d& position_m = room.grid().station(station).position_m;
    InverseDistanceMap map = true_map(plain_room().scene, position_m, size);
    map.station = station;
    return map;
  }
  // In a room whose station kVisited took `exposure` times the light, as its gain says.
  static Contradictions contradictions_at(double exposure) {
    const DepthTestRoom room(plain_room(), [exposure](StationIndex station, cv::Mat* frame) {
      if (station == kVisited) frame->convertTo(*frame, -1, exposure);
    });
    const DepthPlan plan = plan_depth(room.room(), {.every = 2});
    GainFields gains = unit_gain_fields(room.grid());
    gains[0][8].whole = ColourGain::all(static_cast<float>(1.0 / exposure));
    return find_contradictions(room.room(), plan, gains, [&](StationIndex station) {
      return exact_map(room, station, plan.size);
    });
  }
  // Share of the pixels of `rect` that are left out of the only station of which anything is.
  static double share_found(const Contradictions& found, cv::Rect rect) {
    if (found.stations.size() != 1 || !(found.stations[0].station == kVisited)) return -1.0;
    return cv::countNonZero(mask_of(found.stations[0])(rect)) / static_cast<double>(rect.area());
  }
  // Upright, 1 where anything is left out.
  static cv::Mat mask_of(const ContradictedStation& found) {
    cv::Mat mask = cv::Mat::zeros(64, 128, CV_8UC1);
    for (size_t i = 0; i < found.runs.size(); i += 4) {
      EXPECT_EQ(found.runs[i], found.station.station);
      mask.col(found.runs[i + 1]).rowRange(found.runs[i + 2], found.runs[i + 3]).setTo(1);
    }
    return mask;
  }
};

TEST_F(ContradictionsTest, AreNoneInARoomWhereNothingMoves) {
  EXPECT_THAT(contradictions_of(DepthTestRoom(plain_room())).stations, IsEmpty());
  EXPECT_THAT(contradictions_of(DepthTestRoom(plain_room(), person_in({}, 4.0))).stations,
              IsEmpty());
}

TEST_F(ContradictionsTest, APersonAtOneStationIsLeftOut) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}));
  const Contradictions found = contradictions_of(room);
  EXPECT_EQ(share_found(found, kPerson), 1.0);
  // Not much more than the person: of the sphere it covers 4.8 %.
  double share = 0.0;
  for (int v = 0; v < 64; ++v) {
    const double solid_angle = std::sin((v + 0.5) * kPi / 64.0) * kPi / 64.0 / 2.0 / 128.0;
    share += solid_angle * cv::countNonZero(mask_of(found.stations.at(0)).row(v));
  }
  EXPECT_LT(share, 0.08);
  EXPECT_GT(share, 0.045);
}

TEST_F(ContradictionsTest, AStationWithoutAMapIsComparedToo) {
  const StationIndex without_map{0, 7};
  const DepthTestRoom room(plain_room(), person_in({without_map}));
  const Contradictions found = contradictions_of(room);
  ASSERT_EQ(found.stations.size(), 1u);
  EXPECT_EQ(found.stations[0].station, without_map);
}

TEST_F(ContradictionsTest, APersonWithADistanceOfItsOwnIsLeftOutWithIt) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}));
  const auto nearer = [&](InverseDistanceMap* map) {
    if (!(map->station == kVisited)) return;
    for (int u = kPerson.x; u < kPerson.x + kPerson.width; ++u) {
      for (int v = kPerson.y; v < kPerson.y + kPerson.height; ++v) {
        map->omega[pixel_index(u, v, map->size)] = 1.0f / 0.8f;
      }
    }
  };
  const Contradictions found = contradictions_of(room, 2, nearer);
  EXPECT_GT(share_found(found, kPerson), 0.98);
  // The map gets the wall behind the person.
  const Eigen::Vector3d position_m = room.grid().lines[0].stations[8].position_m;
  const PanoramaSize size{128, 64};
  const InverseDistanceMap truth = true_map(plain_room().scene, position_m, size);
  InverseDistanceMap map = truth;
  map.station = kVisited;
  nearer(&map);
  show_behind(found, 0.01, &map);
  const auto on_person = [&](size_t pixel) {
    const cv::Point at(static_cast<int>(pixel) / size.height,
                       static_cast<int>(pixel) % size.height);
    return kPerson.contains(at);
  };
  EXPECT_GT(share_within(map, truth, 0.05, on_person), 0.95);
}

TEST_F(ContradictionsTest, TheSameInNoisyFrames) {
  const DepthTestRoom room(plain_room(), person_in({kVisited}, 4.0));
  EXPECT_GT(share_found(contradictions_of(room), kPerson), 0.98);
}

TEST_F(ContradictionsTest, ExposuresAreComparedAfterTheirGains) {
  EXPECT_THAT(contradictions_at(0.7).stations, IsEmpty());
}

TEST_F(ContradictionsTest, WhatIsClippedAgreesWithWhatIsBrighter) {
  EXPECT_THAT(contradictions_at(1.8).stations, IsEmpty());
}

TEST_F(ContradictionsTest, MaskedPixelsAreNeitherComparedNorBelieved) {
  const auto mask = [](StationIndex) {
    cv::Mat valid(64, 128, CV_8UC1, cv::Scalar(255));
    valid.rowRange(kPerson.y, 64).setTo(0);
    return valid;
  };
  const DepthTestRoom room(plain_room(), synthetic_grid(plain_room()), person_in({kVisited}), mask);
  EXPECT_THAT(contradictions_of(room).stations, IsEmpty());
}

}  // namespace
}  // namespace raywalk::build_lf
