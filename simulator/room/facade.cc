#include "simulator/room/facade.h"

#include <algorithm>
#include <cmath>

#include "simulator/room/palette.h"
#include "simulator/room/shapes.h"
#include "simulator/room/wall_furnishing.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kBuildingDepth = 8.0;
constexpr double kBarWidth = 0.025;  // of a railing
constexpr double kBarGap = 0.14;
constexpr double kGlassBefore = 0.03;  // a pane of glass before what is behind it

// A rectangle on the front: s to the right and t upwards, from its lower left corner.
struct FrontArea {
  double s0, s1, t0, t1;
};

Surface random_front(HashRandom* random) {
  Surface front = random_plaster(random);
  const double kind = random->uniform();
  if (kind < 0.3) {
    front.pattern = Pattern::kBricks;
    front.period = 0.24F;
    front.base = random_color({0.02, 0.09}, {0.3, 0.6}, {0.35, 0.6}, random);
    front.accent = color_from_hue(0.05, 0.2, 0.4);
  } else if (kind < 0.6) {
    front.pattern = Pattern::kPlain;
    front.base = random_color({0.05, 0.14}, {0.05, 0.35}, {0.45, 0.75}, random);
  }
  return front;
}

// What is behind a window: a dark room, or a curtain.
Surface random_behind(HashRandom* random) {
  if (random->chance(0.3)) return random_fabric(random);
  Surface dark;
  dark.base = random_color({0.5, 0.65}, {0.1, 0.4}, {0.03, 0.1}, random);
  return dark;
}

class BuildingFront {
 public:
  BuildingFront(const Wall& wall, HashRandom random, Facets* facets, Facets* glass)
      : wall_(wall), random_(random), facets_(facets), glass_(glass) {
    stone_ = facets->add_surface(random_front(&random_));
    Surface trim = random_plaster(&random_);
    trim.base = random_shade(0.1, {0.0, 0.15}, {0.55, 0.8}, &random_);
    trim.accent = 0.8F * trim.base;
    trim_ = facets->add_surface(trim);
    wood_ = facets->add_surface(random_lacquer(&random_));
    metal_ = facets->add_surface(random_wood(&random_));
    pane_ = glass == nullptr ? -1 : glass->add_surface({});
  }

  void add() {
    const double ground = std::min(random_.uniform(3.4, 4.0), wall_.height);
    const int storeys =
        std::max(static_cast<int>((wall_.height - ground) / random_.uniform(2.9, 3.5)), 1);
    const int bays = std::max(static_cast<int>(wall_.width / random_.uniform(2.2, 3.2)), 1);
    const double bay = wall_.width / bays, storey = (wall_.height - ground) / storeys;
    const double window_width = random_.uniform(0.38, 0.5) * bay;
    const int door = random_.below(bays), balcony = random_.below(storeys + 1);
    recess_ = random_.uniform(0.12, 0.25);
    for (int i = 0; i < bays; ++i) {
      add_ground_bay({i * bay, (i + 1) * bay, 0.0, ground}, i == door);
      for (int j = 0; j < storeys; ++j) {
        const FrontArea cell{i * bay, (i + 1) * bay, ground + j * storey,
                             ground + (j + 1) * storey};
        add_window_bay(cell, window_width, j == balcony);
      }
    }
    for (int j = 0; j < storeys; ++j) add_ledge(ground + j * storey, 0.14, 0.12);
    add_ledge(wall_.height - 0.3, 0.3, 0.25);
    add_body();
  }

 private:
  // A rectangle `depth` in front of the wall (negative: behind), with the wall's texture.
  void add_wall(const FrontArea& area, double depth, int surface) {
    Facet facet =
        make_rectangle(wall_.point(area.s0, area.t0, depth), (area.s1 - area.s0) * wall_.s_axis,
                       (area.t1 - area.t0) * Vector3d::UnitY(), wall_.inward, surface);
    if (surface == stone_) facet.texture = {wall_.corner, wall_.s_axis, Vector3d::UnitY()};
    facet.room_shell = true;
    facets_->facets.push_back(facet);
  }

  // The wall of `cell` around an opening, its reveals, and what closes it.
  void add_opening(const FrontArea& cell, const FrontArea& hole, int closed_by) {
    add_wall({cell.s0, hole.s0, cell.t0, cell.t1}, 0.0, stone_);
    add_wall({hole.s1, cell.s1, cell.t0, cell.t1}, 0.0, stone_);
    if (hole.t0 > cell.t0) add_wall({hole.s0, hole.s1, cell.t0, hole.t0}, 0.0, stone_);
    add_wall({hole.s0, hole.s1, hole.t1, cell.t1}, 0.0, stone_);
    const Vector3d s = (hole.s1 - hole.s0) * wall_.s_axis;
    const Vector3d t = (hole.t1 - hole.t0) * Vector3d::UnitY(), out = recess_ * wall_.inward;
    const Vector3d low = wall_.point(hole.s0, hole.t0, -recess_), up = Vector3d::UnitY();
    for (const Facet& reveal :
         {make_rectangle(low, out, t, wall_.s_axis, trim_),
          make_rectangle(low + s, out, t, -wall_.s_axis, trim_),
          make_rectangle(low, s, out, up, trim_), make_rectangle(low + t, s, out, -up, trim_)}) {
      facets_->facets.push_back(reveal);
    }
    add_wall(hole, -recess_, closed_by);
  }

  void add_ground_bay(const FrontArea& cell, bool door) {
    const double middle = 0.5 * (cell.s0 + cell.s1);
    const double half = door ? 0.55 : 0.36 * (cell.s1 - cell.s0);
    const FrontArea hole{middle - half, middle + half, door ? 0.0 : 0.7,
                         std::min(door ? 2.4 : 2.9, 0.85 * cell.t1)};
    add_opening(cell, hole, door ? wood_ : facets_->add_surface(random_behind(&random_)));
    if (!door) add_pane(hole);
  }

  void add_window_bay(const FrontArea& cell, double width, bool balcony) {
    const double middle = 0.5 * (cell.s0 + cell.s1), height = cell.t1 - cell.t0;
    const FrontArea hole{middle - 0.5 * width, middle + 0.5 * width,
                         cell.t0 + (balcony ? 0.15 : 0.28) * height, cell.t0 + 0.82 * height};
    add_opening(cell, hole, facets_->add_surface(random_behind(&random_)));
    add_pane(hole);
    add_on_wall(wall_, {middle - 0.03, hole.t0, -recess_}, {middle + 0.03, hole.t1, 0.05 - recess_},
                wood_, facets_);
    if (balcony) {
      add_balcony(hole);
    } else {
      add_on_wall(wall_, {hole.s0 - 0.08, hole.t0 - 0.1, 0.0}, {hole.s1 + 0.08, hole.t0, 0.12},
                  trim_, facets_);
    }
  }

  // A slab, and on it a railing of upright bars.
  void add_balcony(const FrontArea& hole) {
    constexpr double kOut = 0.45, kRail = 0.9;
    const double s0 = hole.s0 - 0.15, s1 = hole.s1 + 0.15, t = hole.t0 - 0.02;
    add_on_wall(wall_, {s0, t - 0.12, 0.0}, {s1, t, kOut}, trim_, facets_);
    add_on_wall(wall_, {s0, t + kRail, kOut - kBarWidth}, {s1, t + kRail + 0.04, kOut}, metal_,
                facets_);
    const int bars = std::max(static_cast<int>((s1 - s0) / kBarGap), 2);
    for (int i = 0; i <= bars; ++i) {
      const double s = s0 + (s1 - s0 - kBarWidth) * i / bars;
      add_on_wall(wall_, {s, t, kOut - kBarWidth}, {s + kBarWidth, t + kRail, kOut}, metal_,
                  facets_);
    }
  }

  void add_pane(const FrontArea& hole) {
    if (glass_ == nullptr) return;
    glass_->facets.push_back(make_rectangle(
        wall_.point(hole.s0, hole.t0, kGlassBefore - recess_), (hole.s1 - hole.s0) * wall_.s_axis,
        (hole.t1 - hole.t0) * Vector3d::UnitY(), wall_.inward, pane_));
  }

  void add_ledge(double t, double height, double out) {
    add_on_wall(wall_, {0.0, t, 0.0}, {wall_.width, t + height, out}, trim_, facets_);
  }

  // Flanks and roof, seen above lower neighbours.
  void add_body() {
    const Vector3d back = -kBuildingDepth * wall_.inward, up = Vector3d::UnitY();
    const Vector3d right = wall_.width * wall_.s_axis;
    for (const Facet& side :
         {make_rectangle(wall_.corner, back, wall_.height * up, -wall_.s_axis, stone_),
          make_rectangle(wall_.corner + right, back, wall_.height * up, wall_.s_axis, stone_),
          make_rectangle(wall_.corner + wall_.height * up, right, back, up, trim_)}) {
      facets_->facets.push_back(side);
    }
  }

  Wall wall_;
  HashRandom random_;
  Facets* facets_;
  Facets* glass_;
  int stone_ = 0, trim_ = 0, wood_ = 0, metal_ = 0, pane_ = 0;
  double recess_ = 0.2;
};

}  // namespace

void add_building(const Wall& front, HashRandom random, Facets* facets, Facets* glass) {
  BuildingFront(front, random, facets, glass).add();
}

}  // namespace raywalk::capture
