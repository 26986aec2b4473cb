#include "simulator/room/hall_stands.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/palette.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kWithin = 0.96;  // of the square's half side, so that edges stay within it

// A box of goods on a board, facing +z or -z.
void add_goods(const Placement& place, const Vector3d& min, const Vector3d& max, HashRandom* random,
               Facets* facets) {
  add_box(place, min, max, facets->add_surface(random_lacquer(random)), facets);
}

void add_board(const StandPlace& stand, double height, HashRandom* random, int wood,
               Facets* facets) {
  constexpr int kGoodsPerSide = 3;
  const double half = 0.5 * kWithin * stand.side, board = 0.02;
  add_box(stand.floor, {-half, height, -half}, {half, height + board, half}, wood, facets);
  const double width = 2.0 * half / kGoodsPerSide;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i < kGoodsPerSide; ++i) {
      const double left = -half + width * i, top = height + board + random->uniform(0.1, 0.26);
      const double inner = 0.06 * half, outer = half * random->uniform(0.5, 0.95);
      add_goods(stand.floor, {left + 0.1 * width, height + board, side > 0.0 ? inner : -outer},
                {left + 0.9 * width, top, side > 0.0 ? outer : -inner}, random, facets);
    }
  }
}

// A back wall along x with boards on both sides, up to above the cameras.
void add_shelf_stand(const StandPlace& stand, HashRandom random, Facets* facets) {
  constexpr double kBoardsApart = 0.32;
  const int wood = facets->add_surface(random_wood(&random));
  const double top = std::min(stand.camera_height * random.uniform(1.1, 1.4), 0.8 * stand.ceiling);
  const double half = 0.5 * kWithin * stand.side;
  add_box(stand.floor, {-half, 0.0, -0.04 * half}, {half, top, 0.04 * half}, wood, facets);
  for (double height = 0.05; height + kBoardsApart < top; height += kBoardsApart) {
    add_board(stand, height, &random, wood, facets);
  }
}

void add_column_stand(const StandPlace& stand, HashRandom random, Facets* facets) {
  const double radius = 0.5 * stand.side * random.uniform(0.4, 0.9);
  const int paint = facets->add_surface(random_lacquer(&random));
  add_rod(stand.floor, {{0, 0, 0}, {0, stand.ceiling, 0}, radius, radius}, paint, facets);
  const double foot = 0.5 * kWithin * stand.side / std::sqrt(2.0);
  add_box(stand.floor, {-foot, 0, -foot}, {foot, 0.25, foot},
          facets->add_surface(random_plaster(&random)), facets);
}

void add_poster_stand(const StandPlace& stand, HashRandom random, Facets* facets) {
  // Turned freely, so it stays within the circle in the square.
  const double half = 0.5 * stand.side * kWithin;
  const Placement turned{stand.floor.origin, random.uniform(-kPi, kPi)};
  const double bottom = 0.5 * stand.camera_height;
  const double top = std::min(1.35 * stand.camera_height, 0.8 * stand.ceiling);
  add_rod(turned, {{0, 0, 0}, {0, bottom, 0}, 0.03, 0.02},
          facets->add_surface(random_lacquer(&random)), facets);
  const double thickness = 0.03 * half;
  add_panel(turned, {-0.99 * half, bottom, -thickness}, {0.99 * half, top, thickness},
            random.branch(0), facets);
}

}  // namespace

void add_stand(const StandPlace& place, HashRandom random, Facets* facets) {
  const double kind = random.uniform();
  if (kind < 0.5) {
    add_shelf_stand(place, random.branch(0), facets);
  } else if (kind < 0.75) {
    add_column_stand(place, random.branch(1), facets);
  } else {
    add_poster_stand(place, random.branch(2), facets);
  }
}

void add_panel(const Placement& place, const Vector3d& min, const Vector3d& max, HashRandom random,
               Facets* facets) {
  constexpr double kOff = 5e-4;  // of the picture before the panel
  add_box(place, min, max, facets->add_surface(random_wood(&random)), facets);
  const Vector3d size = max - min;
  for (const double side : {-1.0, 1.0}) {
    Surface picture;
    picture.pattern = Pattern::kPicture;
    picture.extent = {static_cast<float>(size.x()), static_cast<float>(size.y())};
    picture.base = random_color({0.0, 1.0}, {0.1, 0.6}, {0.4, 0.8}, &random);
    picture.accent = random_color({0.0, 1.0}, {0.2, 0.7}, {0.3, 0.8}, &random);
    picture.seed = static_cast<std::uint32_t>(random.bits());
    // s is to the right as seen from the picture's front.
    const Vector3d corner(side > 0.0 ? max.x() : min.x(), min.y(),
                          side > 0.0 ? max.z() + kOff : min.z() - kOff);
    facets->facets.push_back(make_rectangle(
        place.point(corner), place.direction({-side * size.x(), 0, 0}), {0, size.y(), 0},
        place.direction({0, 0, side}), facets->add_surface(picture)));
  }
}

}  // namespace raywalk::capture
