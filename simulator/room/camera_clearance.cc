#include "simulator/room/camera_clearance.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr int kLooks = 64;
constexpr int kLevelLooks = 48;

// Directions distributed evenly over the sphere (Fibonacci lattice): equal steps in height, golden
// angle in longitude.
Vector3d spread_direction(int index) {
  const double golden_angle = kPi * (3.0 - std::sqrt(5.0));
  const double height = (2.0 * index + 1.0) / kLooks - 1.0;
  return direction_from_angles({wrap_angle(golden_angle * index), std::asin(height)});
}

[[noreturn]] void throw_at(const RoomPlan& plan, const Vector3d& position_m, const char* what) {
  throw Error(fmt::format("virtual room of seed {}: the camera at ({:g}, {:g}, {:g}) m {}",
                          plan.seed, position_m.x(), position_m.y(), position_m.z(), what));
}

bool is_in_box(const Vector3d& at, const RoomBox& box) {
  return at.x() > box.x_min && at.x() < box.x_max && at.y() > box.y_min && at.y() < box.y_max &&
         at.z() > box.z_min && at.z() < box.z_max;
}

}  // namespace

void require_free_camera(const RoomPlan& plan, const RoomScene& scene, const Vector3d& position_m) {
  if (!position_m.allFinite()) throw_at(plan, position_m, "has no finite position");
  const Vector3d at = position_m / plan.unit_m;
  if (!is_in_box(at, plan.walls)) throw_at(plan, position_m, "is outside the room");
  // Inside a solid, rays in all directions hit back faces. A single back face may be a ray that
  // grazes an edge.
  int backs = 0;
  for (int i = 0; i < kLooks; ++i) {
    const Vector3d direction = spread_direction(i);
    const Hit hit = scene.geometry().intersect(Ray{at, direction});
    if (hit.facet < 0) continue;
    const Facet& facet = scene.facet(hit.facet);
    if (!facet.two_sided && facet.normal.dot(direction) > 0.0) ++backs;
  }
  if (backs > kLooks / 4) {
    throw_at(plan, position_m, "is inside furniture; move it, or use another seed");
  }
}

void require_clear_lines(const RoomPlan& plan, const RoomScene& scene) {
  for (const PlannedLine& line : plan.lines) {
    for (const double along : line.along) {
      const Vector3d at = line.position(along);
      for (int i = 0; i < kLevelLooks; ++i) {
        const Vector3d level = direction_from_angles({kTwoPi * i / kLevelLooks - kPi, 0.0});
        if (!scene.geometry().occluded({at, level}, (1.0 - 1e-6) * plan.clearance)) continue;
        throw_at(
            plan, plan.unit_m * at,
            "is a station with an object nearer than a quarter of the cell's side; use another "
            "seed, or put less in the room (contents)");
      }
    }
  }
}

}  // namespace raywalk::capture
