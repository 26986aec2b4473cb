#include "simulator/room/free_space.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTries = 2000;
constexpr double kGap = 0.03;  // between neighbours, on the floor and on walls

PlanRectangle around_line(const PlannedLine& line, double clearance) {
  const double middle = 0.5 * (line.along.front() + line.along.back());
  const double half = 0.5 * (line.along.back() - line.along.front()) + clearance;
  if (line.axis == LineAxis::kX) return {{middle, line.across}, {half, clearance}, 0.0};
  return {{line.across, middle}, {clearance, half}, 0.0};
}

bool overlaps_any(const PlanRectangle& place, const std::vector<PlanRectangle>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const PlanRectangle& other) { return overlap(place, other); });
}

}  // namespace

std::vector<Wall> walls_of(const RoomPlan& plan) {
  const RoomBox& box = plan.walls;
  const double width = box.x_max - box.x_min, depth = box.z_max - box.z_min;
  const double height = box.y_max - box.y_min;
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ();
  return {{{box.x_min, box.y_min, box.z_max}, x, -z, width, height},
          {{box.x_max, box.y_min, box.z_max}, -z, -x, depth, height},
          {{box.x_max, box.y_min, box.z_min}, -x, z, width, height},
          {{box.x_min, box.y_min, box.z_min}, z, x, depth, height}};
}

void throw_no_place(const RoomPlan& plan, const std::string& what) {
  throw UsageError(fmt::format(
      "the virtual room of seed {} has no space left for {}; make the room larger, or put less in "
      "it (contents)",
      plan.seed, what));
}

FreeSpace::FreeSpace(const RoomPlan& plan) : plan_(plan), walls_(walls_of(plan)) {
  // Cells are kept free as well as lines, for the viewpoints of true views.
  cameras_.push_back(
      {{0, 0}, {plan.grid_half_x() + plan.clearance, plan.grid_half_z() + plan.clearance}, 0.0});
  for (const PlannedLine& line : plan.lines) cameras_.push_back(around_line(line, plan.clearance));
}

bool FreeSpace::is_tall(double top) const { return top > -plan_.walls.y_min - plan_.headroom; }

bool FreeSpace::is_free(const PlanRectangle& place, double top) const {
  PlanRectangle spaced = place;
  spaced.half_size.array() += kGap;
  if (!inside(place, {plan_.walls.x_min + kGap, plan_.walls.z_min + kGap},
              {plan_.walls.x_max - kGap, plan_.walls.z_max - kGap})) {
    return false;
  }
  return !overlaps_any(spaced, low_) && !overlaps_any(spaced, tall_) &&
         !(is_tall(top) && overlaps_any(place, cameras_));
}

void FreeSpace::take(const PlanRectangle& place, double top) {
  (is_tall(top) ? tall_ : low_).push_back(place);
}

bool FreeSpace::try_stand(const PlanRectangle& place, double top) {
  if (!is_free(place, top)) return false;
  take(place, top);
  return true;
}

PlanRectangle FreeSpace::stand(const Piece& piece, HashRandom* random) {
  for (int i = 0; i < kTries; ++i) {
    PlanRectangle place{{random->uniform(plan_.walls.x_min, plan_.walls.x_max),
                         random->uniform(plan_.walls.z_min, plan_.walls.z_max)},
                        0.5 * piece.size,
                        random->uniform(-kPi, kPi)};
    if (try_stand(place, piece.top)) return place;
  }
  throw_no_place(plan_, piece.name);
}

PlanRectangle FreeSpace::stand_at_wall(const Piece& piece, HashRandom* random) {
  const double half_width = 0.5 * piece.size.x();
  for (int i = 0; i < kTries; ++i) {
    const int number = random->below(static_cast<int>(walls_.size()));
    const Wall& wall = walls_[static_cast<std::size_t>(number)];
    if (wall.width < piece.size.x() + 4.0 * kGap) continue;
    const double s = random->uniform(half_width + kGap, wall.width - half_width - kGap);
    const Vector3d centre = wall.point(s, 0.0, 0.5 * piece.size.y() + 2.0 * kGap);
    PlanRectangle place{
        {centre.x(), centre.z()}, 0.5 * piece.size, angles_from_direction(wall.inward).theta_rad};
    const WallArea area{number, s - half_width, s + half_width, 0.0, piece.top};
    const bool covers_wall = is_tall(piece.top);
    if ((covers_wall && !is_free(area)) || !try_stand(place, piece.top)) continue;
    if (covers_wall) hung_.push_back(area);
    return place;
  }
  throw_no_place(plan_, piece.name);
}

bool FreeSpace::is_free(const WallArea& area) const {
  const Wall& wall = walls_[static_cast<std::size_t>(area.wall)];
  if (area.s_min < kGap || area.s_max > wall.width - kGap || area.t_max > wall.height - kGap) {
    return false;
  }
  return std::none_of(hung_.begin(), hung_.end(), [&](const WallArea& other) {
    return other.wall == area.wall && area.s_min < other.s_max + kGap &&
           area.s_max > other.s_min - kGap && area.t_min < other.t_max + kGap &&
           area.t_max > other.t_min - kGap;
  });
}

std::optional<WallArea> FreeSpace::hang(int wall, const Vector2d& size, double t_min, double t_max,
                                        HashRandom* random) {
  for (int i = 0; i < kTries; ++i) {
    const int number = wall >= 0 ? wall : random->below(static_cast<int>(walls_.size()));
    const double s = random->uniform(0.0, walls_[static_cast<std::size_t>(number)].width);
    const double t = random->uniform(t_min, t_max);
    const WallArea area{number, s, s + size.x(), t, t + size.y()};
    if (!is_free(area)) continue;
    hung_.push_back(area);
    return area;
  }
  return std::nullopt;
}

bool FreeSpace::is_clear_at_camera_height(const PlanRectangle& place) const {
  return inside(place, {plan_.walls.x_min, plan_.walls.z_min},
                {plan_.walls.x_max, plan_.walls.z_max}) &&
         !overlaps_any(place, cameras_) && !overlaps_any(place, tall_);
}

}  // namespace raywalk::capture
