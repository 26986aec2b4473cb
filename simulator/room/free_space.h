// Finds free space for objects on the floor and walls of a room.
//
// Positions are drawn at random until one is free (rejection sampling), so they are uniformly
// distributed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simulator/room/hash_random.h"
#include "simulator/room/plan_rectangle.h"
#include "simulator/room/room_plan.h"

namespace raywalk::capture {

// The inside of a wall. From its lower left corner as seen from the room, s is to the right and t
// upwards.
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

// In the order front (z max), right (x max), back, left of Side in core/geometry/grid.h.
std::vector<Wall> walls_of(const RoomPlan& plan);

// An upright rectangle on a wall.
struct WallArea {
  int wall = 0;
  double s_min = 0.0, s_max = 0.0;
  double t_min = 0.0, t_max = 0.0;
};

// A piece of furniture to place; `top` is its height above the floor.
struct Piece {
  std::string name;                // for errors
  Eigen::Vector2d size{0.5, 0.5};  // along its own x and z
  double top = 1.0;
};

// Throws UsageError naming the seed: the room has no space left for `what`.
[[noreturn]] void throw_no_place(const RoomPlan& plan, const std::string& what);

class FreeSpace {
 public:
  explicit FreeSpace(const RoomPlan& plan);

  // Reserves a random position and rotation on the floor; pieces that reach up to the cameras keep
  // clear of the grid. Throws UsageError naming piece and seed if there is none.
  PlanRectangle stand(const Piece& piece, HashRandom* random);
  // The same with its back (-z side) to a wall. A tall piece also reserves that part of the wall; a
  // low one may stand in front of hanging objects.
  PlanRectangle stand_at_wall(const Piece& piece, HashRandom* random);
  // Reserves exactly `place`; returns false if it is not free.
  bool try_stand(const PlanRectangle& place, double top);

  // Reserves a free rectangle on the wall (-1: any wall) whose lower edge is between t_min and
  // t_max. Empty if there is none.
  std::optional<WallArea> hang(int wall, const Eigen::Vector2d& size, double t_min, double t_max,
                               HashRandom* random);

  // Whether an object hanging at camera height within the rectangle keeps clear of cameras and tall
  // furniture.
  bool is_clear_at_camera_height(const PlanRectangle& place) const;

 private:
  // Whether furniture of this height reaches up to the cameras.
  bool is_tall(double top) const;
  bool is_free(const PlanRectangle& place, double top) const;
  bool is_free(const WallArea& area) const;
  void take(const PlanRectangle& place, double top);

  RoomPlan plan_;
  std::vector<Wall> walls_;
  std::vector<PlanRectangle> cameras_;  // areas that tall pieces keep clear of
  std::vector<PlanRectangle> low_, tall_;
  std::vector<WallArea> hung_;
};

}  // namespace raywalk::capture
