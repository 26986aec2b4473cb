#include "simulator/room/furnishing.h"

#include <algorithm>
#include <array>

#include "core/geometry/sphere.h"
#include "simulator/room/free_space.h"
#include "simulator/room/furniture.h"
#include "simulator/room/palette.h"
#include "simulator/room/shapes.h"
#include "simulator/room/wall_furnishing.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostChairsAtTable = 4;

// One branch of the seed's random numbers per object, so that omitting an object affects only the
// positions of the others.
enum Branch : std::uint64_t {
  kShell = 10,
  kBeams,
  kWalls,
  kWindow,
  kMirror,
  kWallpaper,
  kPlainPatch,
  kPictures,
  kShelf,
  kTable,
  kSofa,
  kPlant,
  kCoatStand,
  kChairs,
  kRug,
  kLamp,
  kSky,
  kSkirting,
  kGlass
};

Placement on_floor(const PlanRectangle& place, const RoomPlan& plan) {
  return {{place.centre.x(), plan.walls.y_min, place.centre.y()}, place.yaw_rad};
}

// Assigns one of the four walls each to window, mirror, wallpaper and plain patch.
std::array<int, 4> shuffled_walls(HashRandom random) {
  std::array<int, 4> walls{0, 1, 2, 3};
  for (int i = 3; i > 0; --i) {
    std::swap(walls[static_cast<std::size_t>(i)],
              walls[static_cast<std::size_t>(random.below(i + 1))]);
  }
  return walls;
}

class Furnisher {
 public:
  Furnisher(const RoomPlan& plan, const ContentSettings& contents)
      : plan_(plan),
        contents_(contents),
        random_(hash_bits(static_cast<std::uint64_t>(plan.seed), 0xf0)),
        space_(plan) {}

  FurnishedRoom furnish() {
    add_shell(plan_, contents_, random_.branch(kShell), &room_.facets);
    if (contents_.skirting) add_skirting(plan_, random_.branch(kSkirting), &room_.facets);
    if (contents_.beams) add_beams(plan_, random_.branch(kBeams), &room_.facets);
    room_.lights.sky_seed = static_cast<std::uint32_t>(random_.branch(kSky).bits());
    furnish_walls();
    furnish_floor();
    if (contents_.lamp) hang_lamp(random_.branch(kLamp));
    for (int i = 0; i < contents_.glass; ++i) {
      stand_glass(random_.branch(kGlass).branch(static_cast<std::uint64_t>(i)));
    }
    return std::move(room_);
  }

 private:
  // Largest objects first.
  void furnish_walls() {
    const auto wall = shuffled_walls(random_.branch(kWalls));
    Facets* facets = &room_.facets;
    if (contents_.window) {
      room_.lights.window =
          add_window(plan_, wall[0], contents_.sun_patch, &space_, random_.branch(kWindow), facets);
    }
    if (contents_.wallpaper) {
      add_wallpaper(plan_, wall[1], &space_, random_.branch(kWallpaper), facets);
    }
    if (contents_.mirror) add_mirror(plan_, wall[2], &space_, random_.branch(kMirror), facets);
    if (contents_.plain_patch) {
      add_plain_patch(plan_, wall[3], &space_, random_.branch(kPlainPatch), facets);
    }
  }

  void furnish_floor() {
    Facets* facets = &room_.facets;
    if (contents_.shelf) {
      HashRandom random = random_.branch(kShelf);
      const Piece shelf = shelf_piece(plan_.walls.y_max - plan_.walls.y_min);
      const PlanRectangle place = space_.stand_at_wall(shelf, &random);
      add_shelf(on_floor(place, plan_), shelf.top, random, facets);
    }
    add_pictures(plan_, contents_.pictures, &space_, random_.branch(kPictures), facets);
    if (contents_.sofa) {
      HashRandom random = random_.branch(kSofa);
      const PlanRectangle place = space_.stand_at_wall(sofa_piece(), &random);
      add_sofa(on_floor(place, plan_), random, facets);
    }
    add_standing(contents_.plant, plant_piece(), kPlant, add_plant);
    add_standing(contents_.coat_stand, coat_stand_piece(), kCoatStand, add_coat_stand);
    int seated = 0;
    if (contents_.table) seated = add_dining_table(random_.branch(kTable));
    for (int i = seated; i < contents_.chairs; ++i) {
      HashRandom random = random_.branch(kChairs).branch(static_cast<std::uint64_t>(i));
      const PlanRectangle place = space_.stand(chair_piece(), &random);
      add_chair(on_floor(place, plan_), random, facets);
    }
    if (contents_.rug) lay_rug(random_.branch(kRug));
  }

  template <typename Add>
  void add_standing(bool wanted, const Piece& piece, Branch branch, const Add& add) {
    if (!wanted) return;
    HashRandom random = random_.branch(branch);
    const PlanRectangle place = space_.stand(piece, &random);
    add(on_floor(place, plan_), random, &room_.facets);
  }

  // Placed last, so that everything else stays where it is.
  void stand_glass(HashRandom random) {
    const Piece pane = glass_piece(plan_.walls.y_max - plan_.walls.y_min);
    const PlanRectangle place = space_.stand(pane, &random);
    add_glass(on_floor(place, plan_), pane.top, random, &room_.facets, &room_.glass);
  }

  // The table with up to four chairs at its long sides; returns the number of chairs placed.
  int add_dining_table(HashRandom random) {
    const PlanRectangle place = space_.stand(table_piece(), &random);
    const Placement table = on_floor(place, plan_);
    add_table(table, random, &room_.facets);
    int seated = 0;
    for (int i = 0; i < std::min(contents_.chairs, kMostChairsAtTable); ++i) {
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Vector3d at = table.point({i < 2 ? -0.33 : 0.33, 0, side * random.uniform(0.74, 0.85)});
      // A chair's back is on its -z side, away from the table.
      const double yaw = table.yaw_rad + (side > 0.0 ? kPi : 0.0) + random.uniform(-0.12, 0.12);
      const Piece chair = chair_piece();
      const PlanRectangle seat{{at.x(), at.z()}, 0.5 * chair.size, yaw};
      if (!space_.try_stand(seat, chair.top)) continue;
      add_chair(on_floor(seat, plan_),
                random_.branch(kChairs).branch(static_cast<std::uint64_t>(seated)), &room_.facets);
      ++seated;
    }
    return seated;
  }

  // May lie under other objects, so it reserves no space.
  void lay_rug(HashRandom random) {
    const double room_x = plan_.walls.x_max - plan_.walls.x_min;
    const double room_z = plan_.walls.z_max - plan_.walls.z_min;
    const double depth = std::min(random.uniform(1.2, 1.8), 0.6 * room_z);
    const Vector2d size(std::min(random.uniform(1.4, 2.4), 0.6 * room_x), depth);
    const double yaw = random.uniform(-0.25, 0.25);
    const PlanRectangle place{
        {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)}, 0.5 * size, yaw};
    Surface wool = random_fabric(&random);
    wool.pattern = Pattern::kRug;
    wool.extent = size.cast<float>();
    wool.period = static_cast<float>(random.uniform(0.18, 0.34));
    const Placement floor = on_floor(place, plan_);
    room_.facets.facets.push_back(make_rectangle(
        floor.point({-0.5 * size.x(), 0.006, -0.5 * size.y()}), floor.direction({size.x(), 0, 0}),
        floor.direction({0, 0, size.y()}), Vector3d::UnitY(), room_.facets.add_surface(wool)));
  }

  // A paper lamp on a thin cord, as close to a line as the clearance allows.
  void hang_lamp(HashRandom random) {
    constexpr double kRadius = 0.15;
    const double ceiling = plan_.walls.y_max;
    const double y = std::min(random.uniform(0.15, 0.5), 0.5 * ceiling);
    for (double slack = 0.0;; slack += 0.05) {
      if (slack > 10.0) throw_no_place(plan_, "the lamp");
      const double out = plan_.clearance + kRadius + 0.02 + slack;
      const bool beside_x = random.chance(0.5);
      const double side = random.chance(0.5) ? 1.0 : -1.0, share = random.uniform(-1.0, 1.0);
      const Vector2d at =
          beside_x ? Vector2d(share * plan_.grid_half_x(), side * (plan_.grid_half_z() + out))
                   : Vector2d(side * (plan_.grid_half_x() + out), share * plan_.grid_half_z());
      if (!space_.is_clear_at_camera_height({at, {kRadius, kRadius}, 0.0})) continue;
      add_lamp({at.x(), y, at.y()}, kRadius, ceiling, &random);
      return;
    }
  }

  void add_lamp(const Vector3d& centre, double radius, double ceiling, HashRandom* random) {
    Surface paper;
    paper.pattern = Pattern::kShade;
    paper.base = Color(1.15F, 1.02F, 0.82F);
    paper.period = static_cast<float>(random->uniform(0.02, 0.035));
    paper.seed = static_cast<std::uint32_t>(random->bits());
    const double half_height = radius * random->uniform(0.8, 1.0);
    add_globe(centre, radius, half_height, room_.facets.add_surface(paper), &room_.facets);
    const Vector3d top = centre + half_height * Vector3d::UnitY();
    add_rod({}, {top, {centre.x(), ceiling, centre.z()}, 0.004, 0.004},
            room_.facets.add_surface(random_lacquer(random)), &room_.facets);
    room_.lights.lamps.push_back({.centre = centre, .radius = radius});
  }

  const RoomPlan& plan_;
  const ContentSettings& contents_;
  HashRandom random_;
  FreeSpace space_;
  FurnishedRoom room_;
};

}  // namespace

FurnishedRoom furnish(const RoomPlan& plan, const ContentSettings& contents) {
  return Furnisher(plan, contents).furnish();
}

}  // namespace raywalk::capture
