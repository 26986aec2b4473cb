#include "simulator/room/hall.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/sphere.h"
#include "simulator/room/free_space.h"
#include "simulator/room/hall_stands.h"
#include "simulator/room/palette.h"
#include "simulator/room/shapes.h"
#include "simulator/room/wall_furnishing.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHallLightStep = 0.25;  // of the light map, room units
constexpr double kLampApart = 3.0;       // room units
constexpr double kLampReach = 12.0;      // what is farther gets its light from nearer lamps
constexpr double kBeamApart = 2.0;       // room units
constexpr double kUnderCeiling = 0.2;    // height of beams
constexpr double kLampRadius = 0.12;
constexpr double kLowBoxShare = 0.3;  // of the cells without a stand
constexpr double kSignShare = 0.25;   // of all cells

// The number of pieces of at most `apart` that a length is divided into.
int pieces(double length, double apart) {
  return std::max(static_cast<int>(std::ceil(length / apart)), 1);
}

// Cells in an order that is spread over all of them however many are taken: steps of the golden
// section of their number, which is made coprime to it so that every cell is reached.
std::vector<int> spread(const std::vector<int>& cells) {
  const auto count = static_cast<std::int64_t>(cells.size());
  auto step = std::max<std::int64_t>(std::llround(0.618034 * static_cast<double>(count)), 1);
  while (std::gcd(step, count) != 1) ++step;
  std::vector<int> order;
  for (std::int64_t i = 0; i < count; ++i) {
    order.push_back(cells[static_cast<std::size_t>(i * step % count)]);
  }
  return order;
}

class HallBuilder {
 public:
  HallBuilder(const RoomPlan& plan, const VirtualRoomSettings& settings)
      : plan_(plan),
        settings_(settings),
        random_(hash_bits(static_cast<std::uint64_t>(plan.seed), 0x4a11)) {}

  FurnishedRoom build() {
    const ContentSettings& contents = settings_.contents;
    Facets* facets = &hall_.facets;
    add_shell(plan_, contents, random_.branch(kShell), facets);
    if (contents.skirting) add_skirting(plan_, random_.branch(kSkirting), facets);
    FreeSpace space(plan_);
    add_pictures(plan_, contents.pictures, &space, random_.branch(kPictures), facets);
    if (contents.beams) add_hall_beams(random_.branch(kBeams));
    for (int row = 0; row < plan_.cells_z; ++row) {
      for (int column = 0; column < plan_.cells_x; ++column) fill_cell(column, row);
    }
    hang_lamps(random_.branch(kLamps));
    hall_.lights.sky_seed = static_cast<std::uint32_t>(random_.branch(kSky).bits());
    hall_.lights.grid_step = kHallLightStep;
    return std::move(hall_);
  }

 private:
  // One branch of the seed's random numbers for each.
  enum Part : std::uint64_t { kShell, kSkirting, kPictures, kSky, kBeams, kLamps, kCells };

  // On the floor, in the middle of a cell.
  Placement in_cell(int column, int row) const {
    const Vector2d at = plan_.cell_side * plan_.cell_centre(column, row);
    return {{at.x(), plan_.walls.y_min, at.y()}, 0.0};
  }

  void fill_cell(int column, int row) {
    HashRandom random = random_.branch(kCells).branch(
        static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(plan_.cells_x) +
        static_cast<std::uint64_t>(column));
    const Placement floor = in_cell(column, row);
    if (random.chance(kSignShare)) {
      hang_sign({floor.origin.x(), plan_.walls.y_max, floor.origin.z()}, random.branch(0));
    }
    if (has_stand(settings_.hall, column, row)) {
      add_stand({floor, plan_.walls.y_max - plan_.walls.y_min, -plan_.walls.y_min,
                 plan_.cell_side - 2.0 * plan_.clearance},
                random.branch(1), &hall_.facets);
    } else if (random.chance(kLowBoxShare)) {
      add_low_box(floor, random.branch(2));
    }
  }

  // Ends below the cameras' headroom, so it may be under the lines.
  void add_low_box(const Placement& floor, HashRandom random) {
    const double top = (-plan_.walls.y_min - plan_.headroom) * random.uniform(0.3, 0.9);
    const double half_x = plan_.cell_side * random.uniform(0.1, 0.4);
    const double half_z = plan_.cell_side * random.uniform(0.1, 0.4);
    const Placement turned{floor.origin, random.uniform(-0.4, 0.4)};
    Surface cover = random.chance(0.5) ? random_fabric(&random) : random_lacquer(&random);
    add_box(turned, {-half_x, 0.0, -half_z}, {half_x, top, half_z}, hall_.facets.add_surface(cover),
            &hall_.facets);
  }

  // A printed panel under the ceiling, above the cameras' headroom.
  void hang_sign(const Vector3d& ceiling, HashRandom random) {
    const double bottom = std::max(0.55 * plan_.walls.y_max, 1.05 * plan_.headroom);
    const double top = plan_.walls.y_max - kUnderCeiling;
    if (top <= bottom) return;
    const double half_width = plan_.cell_side * random.uniform(0.2, 0.45);
    const Placement place{{ceiling.x(), 0.0, ceiling.z()}, random.chance(0.5) ? 0.0 : kHalfPi};
    add_panel(place, {-half_width, bottom, -0.01}, {half_width, top, 0.01}, random, &hall_.facets);
  }

  void add_hall_beams(HashRandom random) {
    const RoomBox& box = plan_.walls;
    const int wood = hall_.facets.add_surface(random_wood(&random));
    const int count = pieces(box.z_max - box.z_min, kBeamApart);
    const double drop = std::min(kUnderCeiling, 0.5 * (box.y_max - plan_.headroom));
    for (int i = 0; i < count; ++i) {
      const double at = box.z_min + (box.z_max - box.z_min) * (i + 0.5) / count;
      add_box({}, {box.x_min, box.y_max - drop, at - 0.06}, {box.x_max, box.y_max, at + 0.06}, wood,
              &hall_.facets);
    }
  }

  // Paper lamps in rows under the ceiling, which give all the light.
  void hang_lamps(HashRandom random) {
    const RoomBox& box = plan_.walls;
    Surface paper;
    paper.pattern = Pattern::kShade;
    paper.base = Color(1.15F, 1.02F, 0.82F);
    paper.period = 0.03F;
    paper.seed = static_cast<std::uint32_t>(random.bits());
    const int surface = hall_.facets.add_surface(paper);
    const double y = box.y_max - std::min(0.25, 0.4 * (box.y_max - plan_.headroom));
    const double radius = std::min(kLampRadius, 0.8 * (box.y_max - y));
    const int columns = pieces(box.x_max - box.x_min, kLampApart);
    const int rows = pieces(box.z_max - box.z_min, kLampApart);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const Vector3d centre(box.x_min + (box.x_max - box.x_min) * (column + 0.5) / columns, y,
                              box.z_min + (box.z_max - box.z_min) * (row + 0.5) / rows);
        add_globe(centre, radius, radius, surface, &hall_.facets);
        hall_.lights.lamps.push_back({centre, radius, kLampReach});
      }
    }
  }

  const RoomPlan& plan_;
  const VirtualRoomSettings& settings_;
  HashRandom random_;
  FurnishedRoom hall_;
};

}  // namespace

bool has_stand(const HallSettings& hall, int column, int row) {
  return column % hall.row_every == 1 && (row + 1) % hall.gap_every != 0;
}

RoomPlan plan_hall(const VirtualRoomSettings& settings) {
  RoomPlan plan = plan_room(settings);
  std::vector<int> open;
  for (int cell = 0; cell < plan.cells_x * plan.cells_z; ++cell) {
    if (!has_stand(settings.hall, cell % plan.cells_x, cell / plan.cells_x)) open.push_back(cell);
  }
  plan.truth_cells = spread(open);
  return plan;
}

FurnishedRoom build_hall(const RoomPlan& plan, const VirtualRoomSettings& settings) {
  return HallBuilder(plan, settings).build();
}

}  // namespace raywalk::capture
