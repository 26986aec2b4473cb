// Rooms whose volumes have a polar part show the same as those without one.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "core/view/renderer.h"
#include "core/view/test_generations.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

SyntheticRoomSpec polar_spec(bool polar_part) {
  SyntheticRoomSpec spec = box_room(256);
  spec.distance_width = 64;
  spec.polar_part = polar_part;
  return spec;
}

// Reaches both poles, so that samples of the polar part are masked, or left out.
SyntheticRoomSpec with_pole(SyntheticRoomSpec spec, bool masked) {
  spec.companion = {.hides =
                        [](const std::string&, int station, const Eigen::Vector3d& direction) {
                          return station % 3 != 0 && std::fabs(direction.y()) > 0.995 &&
                                 direction.x() > 0.0;
                        },
                    .masked = masked,
                    .left_out = !masked};
  return spec;
}

void expect_same_views(const SyntheticRoomSpec& with, ViewOptions options) {
  SyntheticRoomSpec spec_without = with;
  spec_without.polar_part = false;
  const TestRoom room(with), without(spec_without);
  ASSERT_TRUE(room.room().volume(0).has_polar_part());
  ASSERT_FALSE(without.room().volume(0).has_polar_part());
  for (const Generation generation : kGenerations) {
    options.generation = generation;
    for (const PlanPoint at : {PlanPoint{0.0, 0.0}, {0.23, 0.31}, {-0.31, 0.12}}) {
      EXPECT_EQ(largest_difference(room.image(options, at), without.image(options, at)), 0.0)
          << generation_name(generation) << " at " << at.x_m << ',' << at.z_m;
    }
  }
}

TEST(RendererPolarPart, ViewsAreThoseWithoutIt) {
  for (const Interpolation interpolation :
       {Interpolation::kLinear, Interpolation::kNearest, Interpolation::kCubic}) {
    expect_same_views(polar_spec(true), {.interpolation = interpolation});
  }
}

TEST(RendererPolarPart, SoAreThoseOfOtherWidths) {
  for (const int width : {96, 192, 200}) {
    SyntheticRoomSpec spec = polar_spec(true);
    spec.width = width;
    spec.distance_width = width / 2;
    expect_same_views(spec, {});
  }
}

TEST(RendererPolarPart, MaskedPixelsOfItAreNotShown) {
  expect_same_views(with_pole(polar_spec(true), true), {});
}

TEST(RendererPolarPart, NeitherAreThoseLeftOut) {
  expect_same_views(with_pole(polar_spec(true), false), {});
}

TEST(RendererPolarPart, IsReadInFewerPlaces) {
  const auto bytes_touched = [](bool polar_part) {
    const TestRoom room(polar_spec(polar_part));
    Renderer renderer(room.room(), {.generation = Generation::kHlfVd});
    renderer.count_bytes(true);
    return renderer.render({0.1, 0.05}).report.bytes_touched;
  };
  const std::int64_t with = bytes_touched(true), without = bytes_touched(false);
  EXPECT_GT(with, 0);
  EXPECT_LT(with, without);
}

}  // namespace
}  // namespace raywalk
