#include "simulator/room/furniture.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/palette.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr double kSeatHeight = 0.46;
constexpr double kPoleHeight = 1.75;

// The placement raised above the floor.
Placement raised(const Placement& place, const Vector3d& by) {
  return {place.point(by), place.yaw_rad};
}

void add_chair_legs(const Placement& place, int wood, Facets* facets) {
  for (const double x : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0}) {
      add_rod(place, {{0.22 * x, 0.0, 0.21 * z}, {0.18 * x, kSeatHeight, 0.17 * z}, 0.012, 0.019},
              wood, facets);
    }
    add_rod(place, {{0.206 * x, 0.16, -0.196}, {0.206 * x, 0.16, 0.196}, 0.009, 0.009}, wood,
            facets);
  }
  add_rod(place, {{-0.206, 0.17, 0.0}, {0.206, 0.17, 0.0}, 0.009, 0.009}, wood, facets);
  add_rod(place, {{-0.197, 0.26, -0.188}, {0.197, 0.26, -0.188}, 0.009, 0.009}, wood, facets);
}

void add_chair_back(const Placement& place, double height, int spindles, int wood, Facets* facets) {
  for (const double x : {-0.19, 0.19}) {
    add_rod(place, {{x, kSeatHeight, -0.18}, {1.08 * x, height, -0.24}, 0.014, 0.012}, wood,
            facets);
  }
  for (int i = 0; i < spindles; ++i) {
    const double x = 0.19 * (2.0 * (i + 1.0) / (spindles + 1.0) - 1.0);
    add_rod(place, {{x, kSeatHeight, -0.18}, {1.08 * x, height - 0.03, -0.237}, 0.0085, 0.0075},
            wood, facets);
  }
  add_box(raised(place, {0, height - 0.04, -0.24}), {-0.22, 0.0, -0.012}, {0.22, 0.07, 0.012}, wood,
          facets);
}

void add_cup(const Placement& place, double x, double z, HashRandom random, Facets* facets) {
  const double height = random.uniform(0.08, 0.22);
  const int glaze = facets->add_surface(random_lacquer(&random));
  add_rod(raised(place, {x, 0, z}),
          {{0, 0, 0}, {0, height, 0}, random.uniform(0.025, 0.04), random.uniform(0.03, 0.05)},
          glaze, facets);
}

void add_lying_books(const Placement& place, double x, double z, HashRandom random,
                     Facets* facets) {
  double height = 0.0;
  for (int i = 0; i < 4; ++i) {
    Surface cover = random_fabric(&random);
    const int surface = facets->add_surface(cover);
    const double thickness = random.uniform(0.02, 0.045);
    const double half_x = random.uniform(0.07, 0.11), half_z = random.uniform(0.1, 0.14);
    const Placement turned{place.point({x, height, z}), place.yaw_rad + random.uniform(-0.3, 0.3)};
    add_box(turned, {-half_x, 0, -half_z}, {half_x, thickness, half_z}, surface, facets);
    height += thickness;
  }
}

// A leaf from `stem` outwards: two triangles that bend down at the tip.
void add_leaf(const Vector3d& stem, const Vector3d& out, double length, int surface,
              Facets* facets) {
  const Vector3d side = Vector3d::UnitY().cross(out).normalized();
  const Vector3d tip = stem + length * out;
  const double half_width = 0.16 * length;
  const Vector3d middle = stem + 0.5 * length * out;
  Facet leaf;
  leaf.corners = {stem, middle + half_width * side, tip, middle - half_width * side};
  leaf.normal = out.cross(side).normalized();
  if (leaf.normal.y() < 0.0) leaf.normal = -leaf.normal;
  leaf.corner_normals.fill(leaf.normal);
  leaf.texture = {stem - half_width * side, side, out};
  leaf.surface = surface;
  leaf.two_sided = true;
  facets->facets.push_back(leaf);
}

}  // namespace

Piece chair_piece() { return {"a chair", {0.52, 0.54}, 1.0}; }
Piece table_piece() { return {"the table", {1.3, 0.8}, kTableHeight + 0.22}; }
Piece sofa_piece() { return {"the sofa", {1.7, 0.82}, 0.85}; }
Piece shelf_piece(double room_height) {
  return {"the shelf", {1.0, 0.3}, std::min(1.95, room_height - 0.15)};
}
Piece plant_piece() { return {"the plant", {0.64, 0.64}, 1.6}; }
Piece coat_stand_piece() { return {"the coat stand", {0.5, 0.5}, kPoleHeight}; }
Piece glass_piece(double room_height) {
  return {"a pane of glass", {1.1, 0.12}, std::min(1.9, room_height - 0.15)};
}

void add_chair(const Placement& place, HashRandom random, Facets* facets) {
  const int wood =
      facets->add_surface(random.chance(0.5) ? random_wood(&random) : random_lacquer(&random));
  const int seat = random.chance(0.5) ? wood : facets->add_surface(random_fabric(&random));
  add_chair_legs(place, wood, facets);
  add_box(raised(place, {0, kSeatHeight, 0}), {-0.22, 0, -0.21}, {0.22, 0.035, 0.22}, seat, facets);
  const int spindles = 5 + random.below(3);
  add_chair_back(place, random.uniform(0.82, 0.95), spindles, wood, facets);
}

void add_table(const Placement& place, HashRandom random, Facets* facets) {
  const int wood = facets->add_surface(random_wood(&random));
  add_box(place, {-0.65, kTableHeight - 0.035, -0.4}, {0.65, kTableHeight, 0.4}, wood, facets);
  for (const double x : {-0.58, 0.58}) {
    for (const double z : {-0.33, 0.33}) {
      add_rod(place, {{1.03 * x, 0, 1.03 * z}, {x, kTableHeight - 0.035, z}, 0.014, 0.024}, wood,
              facets);
    }
  }
  const Placement top = raised(place, {0, kTableHeight, 0});
  for (int i = 0; i < 5; ++i) {
    const double z = random.uniform(-0.3, 0.3);
    const double x = random.uniform(-0.55, 0.1);
    add_cup(top, x, z, random.branch(static_cast<std::uint64_t>(i)), facets);
  }
  const double books_z = random.uniform(-0.2, 0.2);
  const double books_x = random.uniform(0.25, 0.45);
  add_lying_books(top, books_x, books_z, random.branch(9), facets);
}

void add_sofa(const Placement& place, HashRandom random, Facets* facets) {
  const int cloth = facets->add_surface(random_fabric(&random));
  const int cushion = facets->add_surface(random_fabric(&random));
  const int wood = facets->add_surface(random_wood(&random));
  add_box(place, {-0.62, 0.1, -0.2}, {0.62, 0.42, 0.38}, cloth, facets);
  add_box(place, {-0.85, 0.1, -0.41}, {0.85, 0.8, -0.2}, cloth, facets);
  for (const double x : {-0.85, 0.62}) {
    add_box(place, {x, 0.1, -0.2}, {x + 0.23, 0.58, 0.4}, cloth, facets);
    add_box(place, {0.8 * x, 0.0, -0.3}, {0.8 * x + 0.05, 0.1, -0.25}, wood, facets);
    add_box(place, {0.8 * x, 0.0, 0.25}, {0.8 * x + 0.05, 0.1, 0.3}, wood, facets);
  }
  for (int i = 0; i < 3; ++i) {
    const Placement turned{place.point({-0.4 + 0.4 * i, 0.42, -0.08}),
                           place.yaw_rad + random.uniform(-0.3, 0.3)};
    add_box(turned, {-0.17, 0, -0.06}, {0.17, 0.3, 0.06}, cushion, facets);
  }
}

void add_books(const Placement& place, double x_min, double x_max, double height, double depth,
               HashRandom random, Facets* facets) {
  double x = x_min;
  while (true) {
    const double thickness = random.uniform(0.018, 0.06);
    if (x + thickness > x_max) return;
    Surface book = random_fabric(&random);
    book.pattern = Pattern::kBook;
    const double own_height = height * random.uniform(0.62, 0.94);
    book.extent = {static_cast<float>(thickness), static_cast<float>(own_height)};
    // On a box's sides s runs along the longer edge; the spine is added separately so that s runs
    // across and t up it.
    const double front = depth * random.uniform(0.7, 0.95);
    const int cover = facets->add_surface(random_lacquer(&random));
    add_box(place, {x, 0, -0.5 * depth}, {x + thickness, own_height, -0.5 * depth + front}, cover,
            facets);
    facets->facets.push_back(make_rectangle(place.point({x, 0, -0.5 * depth + front + 0.001}),
                                            place.direction({thickness, 0, 0}),
                                            place.direction({0, own_height, 0}),
                                            place.direction({0, 0, 1}), facets->add_surface(book)));
    x += thickness + (random.chance(0.12) ? random.uniform(0.02, 0.12) : 0.001);
  }
}

void add_shelf(const Placement& place, double top, HashRandom random, Facets* facets) {
  const int wood = facets->add_surface(random_wood(&random));
  constexpr double kHalfWidth = 0.5, kHalfDepth = 0.15, kBoard = 0.022;
  for (const double x : {-kHalfWidth, kHalfWidth - kBoard}) {
    add_box(place, {x, 0, -kHalfDepth}, {x + kBoard, top, kHalfDepth}, wood, facets);
  }
  const int boards = std::max(static_cast<int>(top / 0.34), 1);
  const double step = (top - kBoard) / boards;
  for (int i = 0; i <= boards; ++i) {
    add_box(raised(place, {0, i * step, 0}), {-kHalfWidth + kBoard, 0, -kHalfDepth},
            {kHalfWidth - kBoard, kBoard, kHalfDepth}, wood, facets);
    if (i == boards) break;
    add_books(raised(place, {0, i * step + kBoard, 0}), -kHalfWidth + 1.5 * kBoard,
              kHalfWidth - 1.5 * kBoard, step - kBoard, 2.0 * kHalfDepth,
              random.branch(static_cast<std::uint64_t>(i)), facets);
  }
}

void add_plant(const Placement& place, HashRandom random, Facets* facets) {
  Surface clay = random_plaster(&random);
  clay.base = color_from_hue(0.05, 0.6, random.uniform(0.3, 0.6));
  clay.accent = 0.6F * clay.base;
  add_rod(place, {{0, 0, 0}, {0, 0.32, 0}, 0.12, 0.17}, facets->add_surface(clay), facets);
  Surface green;
  green.pattern = Pattern::kLeaf;
  const double green_value = random.uniform(0.12, 0.3);
  green.base = color_from_hue(random.uniform(0.25, 0.36), 0.7, green_value);
  green.accent = 2.0F * green.base;
  const int leaf = facets->add_surface(green);
  for (int stem = 0; stem < 7; ++stem) {
    const double theta = kTwoPi * stem / 7.0 + random.uniform(-0.3, 0.3);
    const double height = random.uniform(0.8, 1.4);
    const Vector3d out(std::sin(theta), 0, std::cos(theta));
    const Vector3d base = 0.06 * out + Vector3d(0, 0.3, 0),
                   tip = 0.14 * out + Vector3d(0, height, 0);
    add_rod(place, {base, tip, 0.007, 0.004}, leaf, facets);
    for (int i = 0; i < 6; ++i) {
      const Vector3d from = base + (0.25 + 0.15 * i) * (tip - base);
      const Vector3d towards =
          direction_from_angles({theta + random.uniform(-1.9, 1.9), random.uniform(-0.5, 0.6)});
      add_leaf(place.point(from), place.direction(towards),
               std::min(random.uniform(0.1, 0.2), 0.24 - 0.1 * towards.dot(out)), leaf, facets);
    }
  }
}

void add_coat_stand(const Placement& place, HashRandom random, Facets* facets) {
  const int wood = facets->add_surface(random_wood(&random));
  add_rod(place, {{0, 0.1, 0}, {0, kPoleHeight, 0}, 0.018, 0.014}, wood, facets);
  for (int i = 0; i < 3; ++i) {
    const double turn = kTwoPi * i / 3.0;
    const Vector3d out(std::sin(turn), 0, std::cos(turn));
    add_rod(place, {0.24 * out + Vector3d(0, 0.012, 0), {0, 0.2, 0}, 0.012, 0.012}, wood, facets);
  }
  for (int i = 0; i < 8; ++i) {
    const double turn = 2.4 * i;  // about the golden angle, which spreads the hooks around the pole
    const double height = kPoleHeight - 0.06 * i;
    const Vector3d out(std::sin(turn), 0.5, std::cos(turn));
    add_rod(place,
            {{0, height - 0.08, 0}, 0.14 * out + Vector3d(0, height - 0.08, 0), 0.008, 0.006}, wood,
            facets);
  }
}

void add_glass(const Placement& place, double top, HashRandom random, Facets* facets,
               Facets* glass) {
  constexpr double kHalfWidth = 0.55, kBar = 0.03, kHalfDepth = 0.02;
  const int metal = facets->add_surface(random_lacquer(&random));
  for (const double x : {-kHalfWidth, kHalfWidth - kBar}) {
    add_box(place, {x, 0, -kHalfDepth}, {x + kBar, top, kHalfDepth}, metal, facets);
    add_box(place, {x, 0, -0.06}, {x + kBar, 0.04, 0.06}, metal, facets);
  }
  for (const double y : {0.12, top - kBar}) {
    add_box(place, {-kHalfWidth + kBar, y, -kHalfDepth}, {kHalfWidth - kBar, y + kBar, kHalfDepth},
            metal, facets);
  }
  glass->facets.push_back(make_rectangle(place.point({-kHalfWidth + kBar, 0.12 + kBar, 0}),
                                         place.direction({2.0 * (kHalfWidth - kBar), 0, 0}),
                                         place.direction({0, top - 0.12 - 2.0 * kBar, 0}),
                                         place.direction({0, 0, 1}), glass->add_surface({})));
}

void add_car(const Placement& place, HashRandom random, Facets* facets) {
  const int paint = facets->add_surface(random_lacquer(&random));
  Surface dark;
  dark.base = random_shade(0.6, {0.0, 0.3}, {0.03, 0.07}, &random);
  const int black = facets->add_surface(dark);
  const double half = random.uniform(1.9, 2.15), height = random.uniform(1.4, 1.6);
  add_box(place, {-0.87, 0.25, -half}, {0.87, 0.85, half}, paint, facets);
  add_box(place, {-0.75, 0.85, -0.75 * half}, {0.75, height - 0.06, 0.4 * half}, black, facets);
  add_box(place, {-0.77, height - 0.06, -0.72 * half}, {0.77, height, 0.35 * half}, paint, facets);
  for (const double x : {-0.8, 0.6}) {
    for (const double z : {-0.62, 0.62}) {
      add_rod(place, {{x, 0.31, z * half}, {x + 0.22, 0.31, z * half}, 0.31, 0.31}, black, facets);
    }
  }
}

}  // namespace raywalk::capture
