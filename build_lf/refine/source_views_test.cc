#include "build_lf/refine/source_views.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <optional>

#include "core/files/test_directory.h"
#include "core/geometry/sphere.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk::build_lf {
namespace {

class SourceViewsTest : public testing::Test {
 protected:
  // A room with a pillar in the middle of the cell; only every 4th station has a map.
  SourceViewsTest() {
    spec_.scene.obstacle = SceneBox{{-0.1, -1.0, -0.1}, {0.1, 1.0, 0.1}};
    spec_.width = 256;
    spec_.distance_every = 4;
    write_synthetic_room(spec_, directory_ / "room.lf");
    room_.emplace(Room::open(directory_ / "room.lf"));
  }

  // Whether a station sees the point on its ray in `direction` at `metres`.
  bool sees(const SourceView& view, const Eigen::Vector3d& direction, double metres) const {
    const PixelPosition pixel = pixel_from_angles(angles_from_direction(direction), view.size());
    return view.sees({.u = static_cast<float>(pixel.u),
                      .v = static_cast<float>(pixel.v),
                      .inverse = static_cast<float>(1.0 / metres),
                      .slack = 0.01f});
  }

  SyntheticRoomSpec spec_;
  TestDirectory directory_;
  std::optional<Room> room_;
};

TEST_F(SourceViewsTest, AStationSeesSurfacesAndNothingBehindOrBeforeThem) {
  SourceViews views(*room_);
  // With a map and without one.
  for (const int station : {4, 5}) {
    const auto view = views.of({0, station});
    for (const Eigen::Vector3d& towards :
         {Eigen::Vector3d(0.0, 0.0, -1.0), Eigen::Vector3d(0.6, 0.0, -0.8),
          Eigen::Vector3d(-0.6, 0.48, -0.64), Eigen::Vector3d(0.0, -1.0, 0.0)}) {
      const double metres = distance_at(spec_.scene, view->position_m(), towards);
      EXPECT_TRUE(sees(*view, towards, metres)) << station << ": " << towards.transpose();
      EXPECT_FALSE(sees(*view, towards, 1.3 * metres)) << station;
      EXPECT_FALSE(sees(*view, towards, metres / 1.3)) << station;
    }
    // Past the pillar's edge the wall behind it is seen, but not next to the edge, where pixels
    // mix.
    const Eigen::Vector3d to_edge = Eigen::Vector3d(0.1, 0.0, -0.1) - view->position_m();
    const auto aside = [&](double turn_rad) {
      return Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY()) * to_edge.normalized();
    };
    const double pixel = kTwoPi / spec_.width;
    for (const double pixels : {-6.0, 6.0}) {
      const Eigen::Vector3d towards = aside(pixels * pixel);
      EXPECT_TRUE(sees(*view, towards, distance_at(spec_.scene, view->position_m(), towards)));
    }
  }
}

TEST_F(SourceViewsTest, AreKeptAndMadeAgain) {
  SourceViews views(*room_);
  const auto first = views.of({0, 0});
  EXPECT_EQ(first, views.of({0, 0}));
  EXPECT_NE(first, views.of({1, 0}));
  SourceViews others(*room_);
  EXPECT_TRUE(std::ranges::equal(first->inverse(), others.of({0, 0})->inverse()));
}

}  // namespace
}  // namespace raywalk::build_lf
