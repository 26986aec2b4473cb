// Where in a room there is place left: on the floor and on the walls.
//
// Places are drawn at random until one is free, so each is as likely as any other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/simulated/virtual_room/hash_random.h"
#include "capture/simulated/virtual_room/plan_rectangle.h"
#include "capture/simulated/virtual_room/room_plan.h"

namespace raywalk::capture {

// The inside of a wall. s runs along it to the right of an eye that looks at it, t upwards; both
// count from its lower left corner.
struct Wall {
  Eigen::Vector3d corner{0, 0, 0};
  Eigen::Vector3d s_axis{1, 0, 0};
  Eigen::Vector3d inward{0, 0, -1};
  double width = 0.0;
  double height = 0.0;

  Eigen::Vector3d point(double s, double t, double depth) const {
    return corner + s * s_axis + t * Eigen::Vector3d::UnitY() + depth * inward;
  }
};

// Front (z max), right (x max), back, left, as Side of core/geometry/grid.h.
std::vector<Wall> walls_of(const RoomPlan& plan);

// An upright rectangle on a wall.
struct WallArea {
  int wall = 0;
  double s_min = 0.0, s_max = 0.0;
  double t_min = 0.0, t_max = 0.0;
};

// A piece of furniture looking for a place; `top` is its height above the floor.
struct Piece {
  std::string name;                // for errors
  Eigen::Vector2d size{0.5, 0.5};  // along its own x and z
  double top = 1.0;
};

// Throws UsageError: the room, named by its seed, has no place left for `what`.
[[noreturn]] void throw_no_place(const RoomPlan& plan, const std::string& what);

class FreeSpace {
 public:
  explicit FreeSpace(const RoomPlan& plan);

  // Anywhere on the floor, turned at random; pieces that reach up to the cameras keep clear of the
  // grid. The place is then taken. Throws UsageError naming piece and seed where none is found.
  PlanRectangle stand(const Piece& piece, HashRandom* random);
  // With its back (its -z side) to a wall. A tall piece takes that part of the wall too, a low one
  // may stand in front of what hangs there.
  PlanRectangle stand_at_wall(const Piece& piece, HashRandom* random);
  // Exactly there, if it is free.
  bool try_stand(const PlanRectangle& place, double top);

  // A free rectangle of the wall (of any wall for -1) whose lower rim lies between t_min and t_max.
  // It is then taken. None where there is no place.
  std::optional<WallArea> hang(int wall, const Eigen::Vector2d& size, double t_min, double t_max,
                               HashRandom* random);

  // Whether something that hangs at camera height within the rectangle keeps clear of the cameras
  // and of tall furniture.
  bool is_clear_at_camera_height(const PlanRectangle& place) const;

 private:
  // Whether furniture of that height reaches up to the cameras.
  bool is_tall(double top) const;
  bool is_free(const PlanRectangle& place, double top) const;
  bool is_free(const WallArea& area) const;
  void take(const PlanRectangle& place, double top);

  RoomPlan plan_;
  std::vector<Wall> walls_;
  std::vector<PlanRectangle> cameras_;  // what tall pieces keep clear of
  std::vector<PlanRectangle> low_, tall_;
  std::vector<WallArea> hung_;
};

}  // namespace raywalk::capture
