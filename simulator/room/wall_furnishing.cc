#include "simulator/room/wall_furnishing.h"

#include <fmt/format.h>

#include <algorithm>

#include "simulator/room/palette.h"
#include "simulator/room/shapes.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPanelDepth = 0.012;
constexpr double kFrameDepth = 0.035;  // less than LightMap's ray offset from the shell
constexpr double kFrameWidth = 0.035;
constexpr double kPictureFrameWidth = 0.025;
constexpr double kWindowFrameWidth = 0.06;
constexpr double kPaneDepth = 0.004;
constexpr double kHalfBar = 0.018;
constexpr double kSkirtingHeight = 0.09;

WallArea area_for(const char* what, const RoomPlan& plan, int wall, const Vector2d& size,
                  double t_min, double t_max, FreeSpace* space, HashRandom* random) {
  const auto area = space->hang(wall, size, t_min, t_max, random);
  if (area) return *area;
  throw_no_place(plan, fmt::format("{} on a wall", what));
}

// A flat picture on the wall at a depth.
void add_pane(const Wall& wall, const WallArea& area, double depth, int surface, Facets* facets) {
  facets->facets.push_back(make_rectangle(
      wall.point(area.s_min, area.t_min, depth), (area.s_max - area.s_min) * wall.s_axis,
      (area.t_max - area.t_min) * Vector3d::UnitY(), wall.inward, surface));
}

// The area inside a frame of this width, reduced by half the frame on every side so that no edges
// coincide.
WallArea framed(WallArea area, double frame_width) {
  const double inset = 0.5 * frame_width;
  return {area.wall, area.s_min + inset, area.s_max - inset, area.t_min + inset,
          area.t_max - inset};
}

// Four bars along the edges of the area, inside it.
void add_frame(const Wall& wall, const WallArea& area, double width, double depth, int surface,
               Facets* facets) {
  const double s0 = area.s_min, s1 = area.s_max, t0 = area.t_min, t1 = area.t_max;
  add_on_wall(wall, {s0, t0, 0}, {s1, t0 + width, depth}, surface, facets);
  add_on_wall(wall, {s0, t1 - width, 0}, {s1, t1, depth}, surface, facets);
  add_on_wall(wall, {s0, t0 + width, 0}, {s0 + width, t1 - width, depth}, surface, facets);
  add_on_wall(wall, {s1 - width, t0 + width, 0}, {s1, t1 - width, depth}, surface, facets);
}

Surface random_wall(HashRandom* random) {
  Surface wall = random_plaster(random);
  if (!random->chance(0.3)) return wall;
  wall.pattern = Pattern::kBricks;
  wall.period = static_cast<float>(random->uniform(0.2, 0.27));
  wall.base = random_color({0.02, 0.09}, {0.35, 0.65}, {0.35, 0.6}, random);
  const double accent_value = random->uniform(0.25, 0.45);
  wall.accent = color_from_hue(random->uniform(0.0, 0.06), 0.6, accent_value);
  return wall;
}

Surface random_floor(HashRandom* random) {
  Surface floor = random_wood(random);
  if (random->chance(0.6)) {
    floor.pattern = Pattern::kBoards;
    floor.period = static_cast<float>(random->uniform(0.09, 0.15));
    floor.accent = floor.base * 0.7F;
    return floor;
  }
  floor.pattern = Pattern::kTiles;
  floor.period = static_cast<float>(random->uniform(0.28, 0.42));
  const double hue = random->uniform();
  floor.base = random_shade(hue, {0.05, 0.3}, {0.4, 0.65}, random);
  floor.accent = random_shade(hue + 0.04, {0.1, 0.4}, {0.15, 0.4}, random);
  return floor;
}

void add_shell_facet(Facet facet, Facets* facets) {
  facet.room_shell = true;
  facets->facets.push_back(facet);
}

// Direction to the sun such that its light falls through the middle of the window onto the floor,
// some distance into the room.
Vector3d sun_direction(const Wall& wall, const Vector3d& middle, HashRandom* random) {
  const double height = middle.y() - wall.corner.y();
  const double aside = random->uniform(-0.5, 0.5);
  const double into_room = random->uniform(0.7, 1.1);
  const Vector3d lit =
      middle + height * (into_room * wall.inward + aside * wall.s_axis - Vector3d::UnitY());
  return (middle - lit).normalized();
}

}  // namespace

void add_on_wall(const Wall& wall, const Vector3d& min, const Vector3d& max, int surface,
                 Facets* facets) {
  // Seen from the room, s is to the right and depth towards the viewer.
  const Vector3d size = max - min;
  const Vector3d s = size.x() * wall.s_axis, t = size.y() * Vector3d::UnitY();
  const Vector3d d = size.z() * wall.inward;
  const Vector3d near = wall.point(min.x(), min.y(), min.z()), far = near + s + t + d;
  const Vector3d up = Vector3d::UnitY();
  for (const Facet& facet :
       {make_rectangle(near + d, s, t, wall.inward, surface),
        make_rectangle(near, d, t, -wall.s_axis, surface),
        make_rectangle(far, -d, -t, wall.s_axis, surface), make_rectangle(near, s, d, -up, surface),
        make_rectangle(far, -s, -d, up, surface)}) {
    facets->facets.push_back(facet);
  }
}

void add_shell(const RoomPlan& plan, const ContentSettings& contents, HashRandom random,
               Facets* facets) {
  const RoomBox& box = plan.walls;
  const Vector3d x((box.x_max - box.x_min) * Vector3d::UnitX());
  const Vector3d z((box.z_max - box.z_min) * Vector3d::UnitZ());
  const int floor = facets->add_surface(random_floor(&random));
  add_shell_facet(make_rectangle({box.x_min, box.y_min, box.z_min}, x, z, Vector3d::UnitY(), floor),
                  facets);
  Surface plaster = random_plaster(&random);
  plaster.base = random_shade(0.1, {0.0, 0.12}, {0.62, 0.75}, &random);
  plaster.accent = 0.85F * plaster.base;
  if (contents.plain_ceiling) plaster.pattern = Pattern::kPlain;
  add_shell_facet(make_rectangle({box.x_min, box.y_max, box.z_min}, x, z, -Vector3d::UnitY(),
                                 facets->add_surface(plaster)),
                  facets);
  int walls = 0;
  for (const Wall& wall : walls_of(plan)) {
    Surface paint = random_wall(&random);
    if (walls++ < contents.plain_walls) paint.pattern = Pattern::kPlain;
    const int surface = facets->add_surface(paint);
    add_shell_facet(make_rectangle(wall.corner, wall.width * wall.s_axis,
                                   wall.height * Vector3d::UnitY(), wall.inward, surface),
                    facets);
  }
}

void add_skirting(const RoomPlan& plan, HashRandom random, Facets* facets) {
  const int wood = facets->add_surface(random_wood(&random));
  for (const Wall& wall : walls_of(plan)) {
    add_on_wall(wall, {0, 0, 0}, {wall.width, kSkirtingHeight, kPanelDepth + 0.003}, wood, facets);
  }
}

void add_beams(const RoomPlan& plan, HashRandom random, Facets* facets) {
  const RoomBox& box = plan.walls;
  const int wood = facets->add_surface(random_wood(&random));
  const bool along_x = box.x_max - box.x_min < box.z_max - box.z_min;
  const double half_width = random.uniform(0.05, 0.09), drop = random.uniform(0.1, 0.16);
  const double from = along_x ? box.z_min : box.x_min, to = along_x ? box.z_max : box.x_max;
  const int count = std::max(static_cast<int>((to - from) / random.uniform(1.1, 1.8)), 1);
  for (int i = 0; i < count; ++i) {
    const double at = from + (to - from) * (i + 0.5) / count;
    const double bottom = box.y_max - drop;
    if (along_x) {
      add_box({}, {box.x_min, bottom, at - half_width}, {box.x_max, box.y_max, at + half_width},
              wood, facets);
    } else {
      add_box({}, {at - half_width, bottom, box.z_min}, {at + half_width, box.y_max, box.z_max},
              wood, facets);
    }
  }
}

WindowLight add_window(const RoomPlan& plan, int wall, bool sun, FreeSpace* space,
                       HashRandom random, Facets* facets) {
  const Wall on = walls_of(plan)[static_cast<std::size_t>(wall)];
  const double height = std::min(random.uniform(1.0, 1.4), 0.55 * on.height);
  const Vector2d size(std::min(random.uniform(1.1, 1.7), 0.5 * on.width), height);
  const double sill = 0.5 * (on.height - size.y());
  const WallArea area =
      area_for("the window", plan, wall, size, 0.7 * sill, 1.2 * sill, space, &random);
  Surface sky;
  sky.pattern = Pattern::kSky;
  const WallArea pane = framed(area, kWindowFrameWidth);
  add_pane(on, pane, kPaneDepth, facets->add_surface(sky), facets);
  const int wood = facets->add_surface(random_lacquer(&random));
  add_frame(on, area, kWindowFrameWidth, kFrameDepth, wood, facets);
  const double s = 0.5 * (area.s_min + area.s_max), t = 0.4 * area.t_min + 0.6 * area.t_max;
  add_on_wall(on, {s - kHalfBar, pane.t_min, 0}, {s + kHalfBar, pane.t_max, 0.9 * kFrameDepth},
              wood, facets);
  add_on_wall(on, {pane.s_min, t - kHalfBar, 0}, {pane.s_max, t + kHalfBar, 0.8 * kFrameDepth},
              wood, facets);
  WindowLight light;
  light.corner = on.point(pane.s_min, pane.t_min, kPaneDepth);
  light.edge_s = (pane.s_max - pane.s_min) * on.s_axis;
  light.edge_t = (pane.t_max - pane.t_min) * Vector3d::UnitY();
  light.inward = on.inward;
  if (sun) {
    light.sun = sun_direction(on, light.corner + 0.5 * (light.edge_s + light.edge_t), &random);
  }
  return light;
}

void add_mirror(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                Facets* facets) {
  const Wall on = walls_of(plan)[static_cast<std::size_t>(wall)];
  const double height = std::min(random.uniform(0.9, 1.5), 0.6 * on.height);
  const Vector2d size(std::min(random.uniform(0.7, 1.1), 0.5 * on.width), height);
  const double low = 0.5 * (on.height - size.y());
  const WallArea area =
      area_for("the mirror", plan, wall, size, 0.7 * low, 1.1 * low, space, &random);
  Surface glass;
  glass.pattern = Pattern::kMirror;
  add_pane(on, framed(area, kFrameWidth), 0.01, facets->add_surface(glass), facets);
  add_frame(on, area, kFrameWidth, kFrameDepth, facets->add_surface(random_wood(&random)), facets);
}

void add_wallpaper(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                   Facets* facets) {
  const Wall on = walls_of(plan)[static_cast<std::size_t>(wall)];
  const Vector2d size(random.uniform(0.35, 0.5) * on.width, 0.9 * on.height);
  const WallArea area = area_for("the wallpaper", plan, wall, size, 0.05 * on.height,
                                 0.05 * on.height, space, &random);
  Surface paper;
  paper.pattern = Pattern::kWallpaper;
  paper.period = static_cast<float>(random.uniform(0.16, 0.28));
  const double hue = random.uniform();
  paper.base = random_shade(hue, {0.1, 0.4}, {0.45, 0.7}, &random);
  const double accent_value = random.uniform(0.15, 0.4);
  paper.accent = color_from_hue(hue + random.uniform(0.0, 0.15), 0.5, accent_value);
  add_on_wall(on, {area.s_min, area.t_min, 0}, {area.s_max, area.t_max, kPanelDepth},
              facets->add_surface(paper), facets);
}

void add_plain_patch(const RoomPlan& plan, int wall, FreeSpace* space, HashRandom random,
                     Facets* facets) {
  const Wall on = walls_of(plan)[static_cast<std::size_t>(wall)];
  const double height = random.uniform(0.35, 0.5) * on.height;
  const Vector2d size(random.uniform(0.25, 0.4) * on.width, height);
  const WallArea area = area_for("the plain patch", plan, wall, size, 0.1 * on.height,
                                 0.5 * on.height, space, &random);
  Surface paint;
  paint.base = random_color({0.0, 1.0}, {0.1, 0.5}, {0.35, 0.65}, &random);
  add_on_wall(on, {area.s_min, area.t_min, 0}, {area.s_max, area.t_max, kPanelDepth},
              facets->add_surface(paint), facets);
}

void add_pictures(const RoomPlan& plan, int count, FreeSpace* space, HashRandom random,
                  Facets* facets) {
  const double height = plan.walls.y_max - plan.walls.y_min;
  for (int i = 0; i < count; ++i) {
    const double picture_height = std::min(random.uniform(0.22, 0.5), 0.4 * height);
    const Vector2d size(random.uniform(0.25, 0.65), picture_height);
    const WallArea area =
        area_for("a picture", plan, -1, size, 0.3 * height, 0.75 * height, space, &random);
    Surface picture;
    picture.pattern = Pattern::kPicture;
    picture.extent = size.cast<float>();
    picture.base = random_color({0.0, 1.0}, {0.1, 0.6}, {0.4, 0.8}, &random);
    picture.accent = random_color({0.0, 1.0}, {0.2, 0.7}, {0.3, 0.8}, &random);
    picture.seed = static_cast<std::uint32_t>(random.bits());
    const Wall on = walls_of(plan)[static_cast<std::size_t>(area.wall)];
    add_pane(on, framed(area, kPictureFrameWidth), 0.01, facets->add_surface(picture), facets);
    add_frame(on, area, kPictureFrameWidth, 0.03, facets->add_surface(random_wood(&random)),
              facets);
  }
}

}  // namespace raywalk::capture
