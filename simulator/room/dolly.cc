#include "simulator/room/dolly.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/sphere.h"
#include "simulator/room/shapes.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

enum Finish { kSteel, kWood, kRubber, kAluminium };

// Scratched and dirty, in the order of Finish.
std::vector<Surface> finishes(double floor_m) {
  const std::array colors{Color(0.10F, 0.11F, 0.13F), Color(0.36F, 0.20F, 0.09F),
                          Color(0.03F, 0.03F, 0.03F), Color(0.45F, 0.46F, 0.48F)};
  std::vector<Surface> surfaces(colors.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    surfaces[i].pattern = i == kWood ? Pattern::kBoards : Pattern::kPlaster;
    surfaces[i].base = colors[i];
    surfaces[i].accent = 0.7F * colors[i];
    surfaces[i].period = static_cast<float>(0.09 * floor_m);
    surfaces[i].seed = 71U + static_cast<std::uint32_t>(i);
  }
  return surfaces;
}

}  // namespace

Facets make_dolly(const DollySettings& dolly, double floor_m) {
  if (!(floor_m > 0.0)) throw Error("the camera on a dolly must be above the floor");
  // In units of the floor's distance.
  constexpr double kTop = -0.86, kBottom = -0.90, kWheel = 0.05, kRailTop = -0.97, kPlate = -0.11;
  const double reach = std::tan(radians_from_degrees(dolly.reach_deg));
  const double half = -kTop * reach;
  Facets made{finishes(floor_m), {}};
  std::vector<Facet>* facets = &made.facets;
  const auto rod = [&](const Vector3d& from, const Vector3d& to, double radius, Finish finish) {
    add_rod({}, {floor_m * from, floor_m * to, floor_m * radius, floor_m * radius}, finish, facets);
  };
  const auto box = [&](const Vector3d& min, const Vector3d& max, Finish finish) {
    add_box({}, floor_m * min, floor_m * max, finish, facets);
  };
  // The plate hides a little more than the pole.
  rod({0, kPlate, 0}, {0, kPlate + 0.01, 0}, 0.055 * reach, kSteel);
  rod({0, kTop, 0}, {0, kPlate, 0}, 0.018, kAluminium);
  box({-half, kBottom, -half}, {half, kTop, half}, kWood);
  box({-0.06, -1.0, -1.1 * half}, {0.06, kRailTop, 1.1 * half}, kSteel);
  for (const double x : {-half, half}) {
    for (const double z : {-0.7 * half, 0.7 * half}) {
      rod({x - 0.03, kWheel - 1.0, z}, {x + 0.03, kWheel - 1.0, z}, kWheel, kRubber);
    }
  }
  return made;
}

}  // namespace raywalk::capture
