#include "simulator/room/street_canyon.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/sphere.h"
#include "simulator/room/facade.h"
#include "simulator/room/furniture.h"
#include "simulator/room/palette.h"
#include "simulator/room/wall_furnishing.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kKerb = 0.12;              // height of the pavement above the roadway
constexpr double kStreetBeyond = 18.0;      // of the street beyond the last stations
constexpr double kSkyAbove = 40.0;          // height of the space in which cameras may be
constexpr double kLeastCameraHeight = 0.5;  // above the roadway
constexpr double kGroundTile = 3.0;         // of the ground, for its light
constexpr double kLeastWidth = 6.0;
constexpr double kLightStep = 0.4;

enum CanyonBranch : std::uint64_t { kStations = 60, kHeight, kWidth, kBuildings, kGround, kCars };

HashRandom canyon_random(int seed) {
  return HashRandom(hash_bits(static_cast<std::uint64_t>(seed), 0xca));
}

double pavement_of(const RoomPlan& plan) {
  return std::clamp(0.17 * (plan.walls.x_max - plan.walls.x_min), 1.3, 2.0);
}

class CanyonBuilder {
 public:
  CanyonBuilder(const RoomPlan& plan, const VirtualRoomSettings& settings)
      : box_(plan.walls),
        settings_(settings),
        random_(canyon_random(plan.seed)),
        kerb_x_(box_.x_max - pavement_of(plan)) {}

  FurnishedRoom build() {
    lay_ground(random_.branch(kGround));
    HashRandom random = random_.branch(kBuildings);
    const double length = box_.z_max - box_.z_min, width = box_.x_max - box_.x_min;
    const Vector3d z = Vector3d::UnitZ(), x = Vector3d::UnitX();
    const double ground = box_.y_min;
    add_row({box_.x_max, ground, box_.z_max}, -z, -x, length, &random);
    add_row({box_.x_min, ground, box_.z_min}, z, x, length, &random);
    add_row({box_.x_min, ground, box_.z_max}, x, -z, width, &random);
    add_row({box_.x_max, ground, box_.z_min}, -x, z, width, &random);
    park_cars(random_.branch(kCars));
    light(random_.branch(kHeight));
    return std::move(canyon_);
  }

 private:
  // Rectangles on the ground, small enough for the light to vary over them.
  void lay(double x0, double x1, double y, int surface) {
    const auto count = static_cast<int>(std::ceil((box_.z_max - box_.z_min) / kGroundTile));
    const double step = (box_.z_max - box_.z_min) / count;
    for (int i = 0; i < count; ++i) {
      Facet tile = make_rectangle({x0, y, box_.z_min + i * step}, {x1 - x0, 0, 0}, {0, 0, step},
                                  Vector3d::UnitY(), surface);
      tile.texture.origin = {x0, y, box_.z_min};
      tile.room_shell = true;
      canyon_.facets.facets.push_back(tile);
    }
  }

  void lay_ground(HashRandom random) {
    Facets* facets = &canyon_.facets;
    Surface asphalt = random_plaster(&random);
    asphalt.base = random_shade(0.6, {0.0, 0.1}, {0.18, 0.26}, &random);
    asphalt.accent = 0.7F * asphalt.base;
    lay(-kerb_x_, kerb_x_, box_.y_min - kKerb, facets->add_surface(asphalt));
    Surface slabs;
    slabs.pattern = Pattern::kTiles;
    slabs.period = 0.4F;
    slabs.base = random_shade(0.1, {0.0, 0.1}, {0.4, 0.55}, &random);
    slabs.accent = 0.6F * slabs.base;
    const int pavement = facets->add_surface(slabs);
    Surface granite = random_plaster(&random);
    granite.base = random_shade(0.1, {0.0, 0.05}, {0.4, 0.5}, &random);
    granite.accent = 0.8F * granite.base;
    const int stone = facets->add_surface(granite),
              iron = facets->add_surface(random_wood(&random));
    constexpr double kKerbWidth = 0.2;
    lay(box_.x_min, -kerb_x_ - kKerbWidth, box_.y_min, pavement);
    lay(kerb_x_ + kKerbWidth, box_.x_max, box_.y_min, pavement);
    for (const double side : {-1.0, 1.0}) {
      const double inner = side * kerb_x_, outer = side * (kerb_x_ + kKerbWidth);
      for (double z = box_.z_min; z < box_.z_max; z += kGroundTile) {
        add_box({}, {std::min(inner, outer), box_.y_min - kKerb, z},
                {std::max(inner, outer), box_.y_min, std::min(z + kGroundTile, box_.z_max)}, stone,
                facets);
      }
      // Bollards: thin posts on the pavement's edge.
      for (double z = box_.z_min + random.uniform(0.5, 2.0); z < box_.z_max;
           z += random.uniform(1.5, 4.0)) {
        add_rod({{side * (kerb_x_ + 0.35), box_.y_min, z}, 0.0},
                {{0, 0, 0}, {0, random.uniform(0.8, 1.1), 0}, 0.045, 0.035}, iron, facets);
      }
    }
  }

  // Buildings side by side from a corner along `s_axis`, which is to the right seen from the
  // street.
  void add_row(const Vector3d& corner, const Vector3d& s_axis, const Vector3d& inward,
               double length, HashRandom* random) {
    double at = 0.0;
    for (int number = 0; at < length; ++number) {
      double width = random->uniform(6.0, 13.0);
      if (length - at - width < 5.0) width = length - at;
      const Wall front{corner + at * s_axis, s_axis, inward, width, random->uniform(9.0, 18.0)};
      add_building(front, random->branch(static_cast<std::uint64_t>(number)), &canyon_.facets,
                   settings_.contents.glass > 0 ? &canyon_.glass : nullptr);
      at += width;
    }
  }

  void park_cars(HashRandom random) {
    constexpr double kLength = 4.3, kHalfWidth = 0.87;
    const double room = box_.z_max - box_.z_min - 2.0 * kLength;
    const int count = settings_.canyon.cars;
    for (int i = 0; i < count; ++i) {
      HashRandom own = random.branch(static_cast<std::uint64_t>(i));
      // Every car has a stretch of its own, so that none overlap.
      const double stretch = room / std::max((count + 1) / 2, 1);
      const int number = i / 2;  // on its side of the street
      const double z = box_.z_min + kLength + stretch * number +
                       own.uniform(0.5 * kLength, std::max(stretch - 0.5 * kLength, 2.2));
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      add_car({{side * (kerb_x_ - kHalfWidth - 0.12), box_.y_min - kKerb, z}, 0.0}, own,
              &canyon_.facets);
    }
  }

  void light(HashRandom random) {
    canyon_.lights.sky_seed = static_cast<std::uint32_t>(random.bits());
    canyon_.lights.open_sky = true;
    canyon_.lights.grid_step = kLightStep;
    canyon_.lights.open_sun =
        direction_from_angles({random.uniform(-0.5, 0.5), random.uniform(0.9, 1.2)});
  }

  RoomBox box_;
  const VirtualRoomSettings& settings_;
  HashRandom random_;
  double kerb_x_;
  FurnishedRoom canyon_;
};

}  // namespace

RoomPlan plan_canyon(const VirtualRoomSettings& settings) {
  const CanyonSettings& canyon = settings.canyon;
  if (canyon.spacing_max_m < canyon.spacing_min_m) {
    throw UsageError(fmt::format("canyon.spacing_max_m is {:g}, less than spacing_min_m, {:g}",
                                 canyon.spacing_max_m, canyon.spacing_min_m));
  }
  if (canyon.width_m > 0.0 && canyon.width_m < kLeastWidth) {
    throw UsageError(
        fmt::format("canyon.width_m is {:g}; use 0 (chosen by the seed) or {:g} to 100",
                    canyon.width_m, kLeastWidth));
  }
  const HashRandom all = canyon_random(settings.seed);
  RoomPlan plan;
  plan.seed = settings.seed;
  PlannedLine line{"z0", LineAxis::kZ, 0.0, {}};
  HashRandom steps = all.branch(kStations);
  double at = 0.0;
  for (int i = 0; i < canyon.stations; ++i) {
    line.along.push_back(at);
    at += steps.uniform(canyon.spacing_min_m, canyon.spacing_max_m);
  }
  const double half = 0.5 * line.along.back();
  for (double& along : line.along) along -= half;
  plan.lines.push_back(line);
  double width = all.branch(kWidth).uniform(8.0, 12.0);
  if (canyon.width_m > 0.0) width = canyon.width_m;
  double height = all.branch(kHeight).uniform(2.2, 2.6);
  if (settings.room.camera_height_m > 0.0) height = settings.room.camera_height_m;
  if (height < kLeastCameraHeight) {
    throw UsageError(fmt::format("room.camera_height_m is {:g}; in a canyon at least {:g}", height,
                                 kLeastCameraHeight));
  }
  plan.walls = {-0.5 * width, 0.5 * width,           kKerb - height,
                kSkyAbove,    -half - kStreetBeyond, half + kStreetBeyond};
  // Balconies may be at the height of the cameras; people walk on the pavement.
  plan.clearance = 0.5 * width - 0.9;
  plan.headroom = kLeastCameraHeight;
  return plan;
}

FurnishedRoom build_canyon(const RoomPlan& plan, const VirtualRoomSettings& settings) {
  return CanyonBuilder(plan, settings).build();
}

}  // namespace raywalk::capture
