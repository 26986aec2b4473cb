#include "capture/plan/plan_picture.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/report/plan_drawing.h"

namespace raywalk::capture {
namespace {

constexpr double kBorder_px = 56.0;
constexpr double kEndGap_px =
    10.0;  // between the outermost stations and the marks at the ends of a line
constexpr double kBarHalf_px = 6.0;
constexpr double kArrowLength_px = 11.0;
constexpr double kArrowHalf_px = 5.0;
constexpr double kLargestStation_px = 2.6;
constexpr double kStationShareOfSpacing = 0.3;
// Closer stations would be one thick line.
constexpr double kClosestStations_px = 2.0;
// Labels closer than this overlap: then only some lines are labelled.
constexpr double kLabelWidth_px = 30.0;

constexpr std::string_view kRules =
    R"(.raywalk-plan .cell { fill: var(--soft); fill-opacity: .08; }
.raywalk-plan .rail { stroke: var(--ink); stroke-width: 1.2; }
.raywalk-plan .overhang { stroke: var(--soft); stroke-width: 1.2; }
.raywalk-plan .kept-out { stroke: var(--accent); stroke-width: 1.2; stroke-dasharray: 5 4; }
.raywalk-plan .station { fill: var(--ink); }
.raywalk-plan .truth { fill: var(--accent); }
.raywalk-plan .placement { stroke: var(--ink); stroke-width: 1; }
.raywalk-plan .start { stroke: var(--ink); stroke-width: 3; }
.raywalk-plan .arrow { fill: var(--ink); }
)";

// The point at `along_m` on the line, offset by `across_m`.
PlanPoint point_on(const CaptureLine& line, double along_m, double across_m = 0.0) {
  const double beside_m = line.across_m + across_m;
  return line.axis == LineAxis::kX ? PlanPoint{along_m, beside_m} : PlanPoint{beside_m, along_m};
}

double along_of(const CaptureLine& line, const CaptureStation& station) {
  return line.axis == LineAxis::kX ? station.position_m.x_m : station.position_m.z_m;
}

// The rectangle of the cells: the lines of the grid without their overhang.
PlanBounds cell_bounds(const CapturePlan& plan) {
  PlanBounds cells;
  for (const CaptureLine& line : plan.lines) {
    if (line.validation) continue;
    cells.add(point_on(line, along_of(line, line.stations.front()) + plan.overhang_m));
    cells.add(point_on(line, along_of(line, line.stations.back()) - plan.overhang_m));
  }
  return cells;
}

PlanBounds station_bounds(const CapturePlan& plan) {
  PlanBounds bounds;
  for (const CaptureLine& line : plan.lines) {
    for (const CaptureStation& station : line.stations) bounds.add(station.position_m);
  }
  return bounds;
}

void draw_cells(const CapturePlan& plan, PlanDrawing* drawing) {
  const PlanBounds cells = cell_bounds(plan);
  const std::array<PlanPoint, 4> corners{cells.min, PlanPoint{cells.max.x_m, cells.min.z_m},
                                         cells.max, PlanPoint{cells.min.x_m, cells.max.z_m}};
  drawing->add_polygon("cell", corners);
}

void draw_rail(const CaptureLine& line, double overhang_m, PlanDrawing* drawing) {
  const double first_m = along_of(line, line.stations.front());
  const double last_m = along_of(line, line.stations.back());
  if (line.validation) {
    drawing->add_line("kept-out", point_on(line, first_m), point_on(line, last_m));
    return;
  }
  drawing->add_line("overhang", point_on(line, first_m), point_on(line, last_m));
  drawing->add_line("rail", point_on(line, first_m + overhang_m),
                    point_on(line, last_m - overhang_m));
}

double spacing_of(const CaptureLine& line) {
  return along_of(line, line.stations[1]) - along_of(line, line.stations.front());
}

void draw_stations(const CaptureLine& line, PlanDrawing* drawing) {
  const double radius_px = std::min(
      kLargestStation_px, kStationShareOfSpacing * spacing_of(line) / drawing->metres_of(1.0));
  for (const CaptureStation& station : line.stations) {
    drawing->add_dot(line.validation ? "truth" : "station", station.position_m, radius_px);
  }
}

// The middle between the placements of the rail.
void draw_placements(const CaptureLine& line, PlanDrawing* drawing) {
  const double half_m = drawing->metres_of(0.5 * kBarHalf_px);
  const std::vector<CaptureLine> placements = placements_of(line);
  for (std::size_t i = 1; i < placements.size(); ++i) {
    const double at_m = along_of(line, placements[i].stations.front()) - 0.5 * spacing_of(line);
    drawing->add_line("placement", point_on(line, at_m, -half_m), point_on(line, at_m, half_m));
  }
}

// Which lines of an axis are labelled: those not too close to the last one that was. Validation
// lines always are.
class LabelledLines {
 public:
  explicit LabelledLines(double apart_m) : apart_m_(apart_m) {}

  bool take(const CaptureLine& line) {
    if (line.validation) return true;
    std::optional<double>& last_m = line.axis == LineAxis::kX ? last_x_m_ : last_z_m_;
    if (last_m && line.across_m - *last_m < apart_m_) return false;
    last_m = line.across_m;
    return true;
  }

 private:
  double apart_m_;
  std::optional<double> last_x_m_{};
  std::optional<double> last_z_m_{};
};

void draw_ends(const CaptureLine& line, bool labelled, PlanDrawing* drawing) {
  const double gap_m = drawing->metres_of(kEndGap_px);
  const double start_m = along_of(line, line.stations.front()) - gap_m;
  const double bar_m = drawing->metres_of(kBarHalf_px);
  drawing->add_line("start", point_on(line, start_m, -bar_m), point_on(line, start_m, bar_m));
  const double tail_m = along_of(line, line.stations.back()) + 0.5 * gap_m;
  const double half_m = drawing->metres_of(kArrowHalf_px);
  const std::array<PlanPoint, 3> arrow{point_on(line, tail_m + drawing->metres_of(kArrowLength_px)),
                                       point_on(line, tail_m, half_m),
                                       point_on(line, tail_m, -half_m)};
  drawing->add_polygon("arrow", arrow);
  if (!labelled) return;
  // Moved aside, because a validation line may start close to a line of the grid.
  if (line.validation && line.axis == LineAxis::kX) {
    drawing->add_label(line.id, point_on(line, start_m, bar_m), LabelSide::kAbove);
  } else {
    drawing->add_label(line.id, point_on(line, start_m),
                       line.axis == LineAxis::kX ? LabelSide::kLeft : LabelSide::kBelow);
  }
}

}  // namespace

std::string plan_picture_svg(const CapturePlan& plan) {
  PlanDrawing drawing(station_bounds(plan), kBorder_px);
  draw_cells(plan, &drawing);
  bool all_drawn = true;
  for (const CaptureLine& line : plan.lines) draw_rail(line, plan.overhang_m, &drawing);
  for (const CaptureLine& line : plan.lines) {
    const bool drawn = spacing_of(line) >= drawing.metres_of(kClosestStations_px);
    if (drawn) draw_stations(line, &drawing);
    all_drawn = all_drawn && drawn;
    draw_placements(line, &drawing);
  }
  LabelledLines labelled(drawing.metres_of(kLabelWidth_px));
  for (const CaptureLine& line : plan.lines) draw_ends(line, labelled.take(line), &drawing);
  const std::string ends = "The rail of a line runs from its bar to its arrow.";
  std::vector<std::string> notes{all_drawn ? "Each dot is a station. " + ends : ends};
  if (!all_drawn) notes.push_back("Stations are too close to each other to be drawn.");
  if (placements_of(plan).size() > plan.lines.size()) {
    notes.push_back("A small mark across a line begins a further placement of the rail.");
  }
  if (std::ranges::any_of(plan.lines, &CaptureLine::validation)) {
    notes.push_back("Dashed: validation lines, which are not part of the light field.");
  }
  return drawing.svg("Plan of the capture from above", kRules, notes);
}

}  // namespace raywalk::capture
