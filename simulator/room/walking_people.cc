#include "simulator/room/walking_people.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/geometry/sphere.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/palette.h"
#include "simulator/room/surface_light.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPlaceStep = 0.05;
constexpr double kHalfWidth = 0.28;  // of a person with swinging arms
constexpr double kTallest = 1.9;
constexpr double kLeastGap = 0.8;  // between two people on the loop
constexpr double kAboveRug = 0.03;
constexpr float kLight = 0.75F;  // the mean light of a room (LightMap)

// Corners of the loop: the stations' bounding box, larger by the plan's clearance and a person.
std::vector<Vector2d> loop_corners(const RoomPlan& plan) {
  Vector2d min(1e30, 1e30), max(-1e30, -1e30);
  for (const PlannedLine& line : plan.lines) {
    for (const double along : {line.along.front(), line.along.back()}) {
      const Vector3d at = line.position(along);
      min = min.cwiseMin(Vector2d(at.x(), at.z()));
      max = max.cwiseMax(Vector2d(at.x(), at.z()));
    }
  }
  const Vector2d beyond = Vector2d::Constant(plan.clearance + kHalfWidth);
  min -= beyond;
  max += beyond;
  return {min, {min.x(), max.y()}, max, {max.x(), min.y()}};
}

// The ground at this place, at most a kerb lower or a rug higher; empty if there is none.
std::optional<Vector3d> ground_at(const Vector3d& floor, const EmbreeScene& room) {
  constexpr double kKnee = 0.5;
  const Hit hit = room.intersect(Ray{floor + Vector3d(0, kKnee, 0), -Vector3d::UnitY()});
  if (hit.facet < 0 || hit.distance < kKnee - kAboveRug || hit.distance > kKnee + 0.2) {
    return std::nullopt;
  }
  return floor + Vector3d(0, kKnee - hit.distance, 0);
}

bool is_free(const Vector3d& feet, const EmbreeScene& room) {
  for (const double x : {-kHalfWidth, 0.0, kHalfWidth}) {
    for (const double z : {-kHalfWidth, 0.0, kHalfWidth}) {
      const Vector3d from = feet + Vector3d(x, kAboveRug, z);
      if (room.occluded({from, Vector3d::UnitY()}, kTallest)) return false;
    }
  }
  // Poles and walls, which rays upwards miss.
  for (const double height : {0.2, 0.8, 1.6}) {
    for (int i = 0; i < 16; ++i) {
      const Vector3d level = direction_from_angles({kTwoPi * i / 16.0 - kPi, 0.0});
      if (room.occluded({feet + Vector3d(0, height, 0), level}, kHalfWidth)) return false;
    }
  }
  return true;
}

// The colour of a person's surface in light from all sides, more of it from above.
Color person_light(const Color& albedo, const Vector3d& normal) {
  return kLight * static_cast<float>(0.8 + 0.2 * normal.y()) * albedo;
}

// Swinging limbs: `phase` is the position in the stride.
void add_person(const Placement& feet, double phase, HashRandom random, Facets* facets) {
  const double height = random.uniform(1.55, kTallest);
  const double swing = 0.22 * std::sin(phase);
  const int trousers = facets->add_surface(random_fabric(&random));
  const int coat =
      facets->add_surface(random.chance(0.5) ? random_fabric(&random) : random_lacquer(&random));
  Surface skin;
  skin.pattern = Pattern::kPlaster;
  skin.base = color_from_hue(0.07, 0.45, random.uniform(0.35, 0.75));
  skin.accent = 0.8F * skin.base;
  const int face = facets->add_surface(skin);
  for (const double side : {-1.0, 1.0}) {
    const Vector3d hip(0.09 * side, 0.49 * height, 0.0);
    add_rod(feet, {{0.1 * side, 0.0, side * swing}, hip, 0.05, 0.08}, trousers, facets);
    const Vector3d shoulder(0.19 * side, 0.8 * height, 0.0);
    const Vector3d hand(0.23 * side, 0.45 * height, -side * swing);
    add_rod(feet, {hand, shoulder, 0.035, 0.055}, coat, facets);
  }
  add_rod(feet, {{0, 0.46 * height, 0}, {0, 0.82 * height, 0}, 0.15, 0.19}, coat, facets);
  add_rod(feet, {{0, 0.81 * height, 0}, {0, 0.88 * height, 0}, 0.055, 0.05}, face, facets);
  add_globe(feet.point({0, 0.935 * height, 0}), 0.085, 0.065 * height, face, facets);
}

Facets built(const std::vector<Placement>& feet, int seed) {
  const HashRandom all(hash_bits(static_cast<std::uint64_t>(seed), 0x9e09));
  Facets facets;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    // A stride of about 1.4 m; everybody in a phase of their own.
    const Vector3d& at = feet[i].origin;
    const double phase = kTwoPi * (at.x() + at.z()) / 1.4 + static_cast<double>(i);
    add_person(feet[i], phase, all.branch(i), &facets);
  }
  return facets;
}

}  // namespace

PeoplePath::PeoplePath(const RoomPlan& plan, const EmbreeScene& room, const PeopleSettings& people)
    : count_(people.count) {
  const std::vector<Vector2d> corners = loop_corners(plan);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d& from = corners[i];
    const Vector2d side = corners[(i + 1) % corners.size()] - from;
    const double length = side.norm();
    const double yaw = std::atan2(side.x(), side.y());
    for (double at = 0.0; at < length; at += kPlaceStep) {
      const Vector2d place = from + at / length * side;
      const auto feet = ground_at({place.x(), plan.walls.y_min, place.y()}, room);
      if (feet && is_free(*feet, room)) places_.push_back({*feet, yaw});
    }
  }
  if (static_cast<double>(places_.size()) * kPlaceStep < count_ * kLeastGap) {
    throw UsageError(fmt::format(
        "virtual room of seed {}: only {:.1f} m of free floor to walk on around the lines; use "
        "fewer people (people.count), a larger room, or another seed",
        plan.seed, static_cast<double>(places_.size()) * kPlaceStep * plan.unit_m));
  }
  HashRandom random(hash_bits(static_cast<std::uint64_t>(plan.seed), 0x9e0));
  start_ = random.uniform(0.0, static_cast<double>(places_.size()));
  step_ = people.step_mm * 1e-3 / plan.unit_m / kPlaceStep;
}

std::vector<Placement> PeoplePath::at(int moment) const {
  std::vector<Placement> feet;
  const auto places = static_cast<double>(places_.size());
  for (int i = 0; i < count_; ++i) {
    const double walked = start_ + step_ * moment + places * i / count_;
    feet.push_back(places_[static_cast<std::size_t>(std::fmod(walked, places))]);
  }
  return feet;
}

PeopleScene::PeopleScene(const std::vector<Placement>& feet, int seed)
    : people_(built(feet, seed)), scene_(people_.facets) {}

Color PeopleScene::light_of(const Ray& ray, const Hit& hit, double pixel_rad) const {
  const Facet& facet = people_.facets[static_cast<std::size_t>(hit.facet)];
  const Surface& surface = people_.surfaces[static_cast<std::size_t>(facet.surface)];
  const double across = hit.distance * pixel_rad;
  return person_light(seen_albedo(facet, surface, ray, hit.distance, across), facet.normal);
}

}  // namespace raywalk::capture
