// Views from distances that cannot be relied on: full of gaps and of wrong pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/view/renderer.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr int kRoomWidth = 256;

// A room of few stations. Of its distances half are right, the others anything; none are confident.
SyntheticRoomSpec room_of_poor_distances(int cells_z) {
  SyntheticRoomSpec spec = box_room(kRoomWidth);
  spec.cells_z = cells_z;
  spec.spacing_m = 0.25;
  spec.stored_distance = [](int u, int v, double exact_m) {
    std::minstd_rand random(static_cast<unsigned>(1 + 613 * u + v));
    random.discard(3);
    if (random() % 2 == 0) return static_cast<float>(exact_m);
    return static_cast<float>(std::uniform_real_distribution<double>(0.2, 8.0)(random));
  };
  spec.stored_confidence = [](int u, int v) {
    return static_cast<std::uint8_t>((7 * u + 3 * v) % 5 == 0 ? 0 : 72);
  };
  return spec;
}

// The frames of the two stations nearest to a viewpoint, by nearness.
cv::Mat cross_fade(const TestRoom& room, PlanPoint at) {
  struct Nearby {
    double distance_m = 0.0;
    PlanPoint position{};
  };
  std::vector<Nearby> stations;
  for (const Line& line : room.room().grid().lines) {
    for (const Station& station : line.stations) {
      const PlanPoint p{station.position_m.x(), station.position_m.z()};
      stations.push_back({std::hypot(p.x_m - at.x_m, p.z_m - at.z_m), p});
    }
  }
  std::ranges::sort(stations, {}, &Nearby::distance_m);
  const double share = stations[1].distance_m / (stations[0].distance_m + stations[1].distance_m);
  cv::Mat mixed;
  cv::addWeighted(room.truth(stations[0].position), share, room.truth(stations[1].position),
                  1.0 - share, 0.0, mixed);
  return mixed;
}

TEST(PoorDistances, NoViewIsWorseThanCrossFadingTheNearestStations) {
  for (const int cells_z : {0, 1}) {
    const TestRoom room(room_of_poor_distances(cells_z));
    const auto places = cells_z == 0
                            ? std::vector<PlanPoint>{{0.1, 0.02}, {-0.3, -0.04}, {0.37, 0.0}}
                            : std::vector<PlanPoint>{{0.1, 0.2}, {-0.3, 0.45}, {0.4, -0.1}};
    for (const PlanPoint at : places) {
      const cv::Mat truth = room.truth(at);
      EXPECT_GT(room.psnr({.method = ViewMethod::kTwoSided}, at),
                psnr_db(cross_fade(room, at), truth))
          << cells_z << " cells, at " << at.x_m << ',' << at.z_m;
    }
  }
}

// Poor distances of one half of the directions do not spoil the other: there the view is the same
// as from exact maps. They are too far, as nearer ones would hide what is right.
TEST(PoorDistances, DoNotSpoilWhatIsConfident) {
  SyntheticRoomSpec spec = box_room(kRoomWidth);
  spec.spacing_m = 0.25;
  const auto is_good = [](int u) { return u < kRoomWidth / 2; };
  spec.stored_distance = [=](int u, int, double exact_m) {
    return static_cast<float>(is_good(u) ? exact_m : 1.5 * exact_m);
  };
  spec.stored_confidence = [=](int u, int) {
    return static_cast<std::uint8_t>(is_good(u) ? 255 : 72);
  };
  const TestRoom room(spec);
  spec.stored_distance = {};
  spec.stored_confidence = {};
  const TestRoom exact(spec);
  const PlanPoint at{0.02, -0.03};
  const ViewOptions options{.method = ViewMethod::kTwoSided};
  // Away from the border between them.
  const cv::Range good(kRoomWidth / 8, 3 * kRoomWidth / 8);
  EXPECT_GT(psnr_db(room.image(options, at).colRange(good).clone(),
                    exact.image(options, at).colRange(good).clone()),
            45.0);
}

}  // namespace
}  // namespace raywalk
