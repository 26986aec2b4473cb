#include "capture/plan/capture_plan.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "capture/base/units.h"

namespace raywalk::capture {
namespace {

constexpr double kMaxStations = 100000.0;
// Tolerance of a whole number of steps, so that a spacing may be given with six digits.
constexpr double kWholeStep = 1e-3;
constexpr double kSamePlace_m = 1e-3;

// Equally spaced positions along an axis.
struct Run {
  double first_m = 0.0;
  double step_m = 0.0;
  int steps = 0;

  double at(int step) const { return first_m + step * step_m; }
  double last_m() const { return at(steps); }
};

struct LinePlace {
  std::string id;
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;
  bool validation = false;
  Run run;
};

// The number of steps of `spacing_mm` that fill a length; none if it is not whole.
std::optional<double> whole_steps(double length_m, double spacing_mm) {
  const double steps = length_m * kMillimetresPerMetre / spacing_mm;
  const double whole = std::round(steps);
  if (whole < 1.0 || std::abs(steps - whole) > kWholeStep) return std::nullopt;
  return whole;
}

// "; 25 or 33.3333 would": the spacings nearest to `spacing_mm` that fill the length.
std::string fitting_spacings(double length_m, double spacing_mm) {
  const double length_mm = length_m * kMillimetresPerMetre;
  const double steps = length_mm / spacing_mm;
  const double fewer = std::max(1.0, std::floor(steps));
  const double more = std::max(1.0, std::ceil(steps));
  if (fewer == more) return fmt::format("; {:.6g} would", length_mm / more);
  return fmt::format("; {:.6g} or {:.6g} would", length_mm / more, length_mm / fewer);
}

double steps_of_cell(const CaptureConfig& config) {
  const CaptureGrid& grid = config.grid;
  const std::optional<double> steps = whole_steps(grid.cell_side_m, grid.spacing_mm);
  if (!steps) {
    refuse_setting(
        config, "grid.spacing_mm",
        fmt::format("is {}; whole steps of it do not fill a cell's side of {} m{}", grid.spacing_mm,
                    grid.cell_side_m, fitting_spacings(grid.cell_side_m, grid.spacing_mm)));
  }
  return *steps;
}

// Called before stations are created: a mistyped spacing should not exhaust the memory.
void require_few_stations(const CaptureConfig& config, std::string_view key, double spacing_mm,
                          double stations) {
  if (stations <= kMaxStations) return;
  refuse_setting(
      config, key,
      fmt::format("is {}, which brings the plan to {:.0f} stations; {:.0f} is the maximum",
                  spacing_mm, stations, kMaxStations));
}

std::vector<LinePlace> grid_lines(const CaptureConfig& config, double* overhang_m) {
  const CaptureGrid& grid = config.grid;
  const double cell_steps = steps_of_cell(config);
  const double step_m = grid.cell_side_m / cell_steps;
  const double wanted_m =
      grid.overhang_mm < 0.0 ? overhang_needed_m(grid) : grid.overhang_mm / kMillimetresPerMetre;
  const double overhang_steps = std::ceil(wanted_m / step_m - kWholeStep);
  *overhang_m = overhang_steps * step_m;
  const auto steps_along = [&](int cells) { return cells * cell_steps + 2.0 * overhang_steps; };
  require_few_stations(config, "grid.spacing_mm", grid.spacing_mm,
                       (grid.cells_z + 1) * (steps_along(grid.cells_x) + 1.0) +
                           (grid.cells_x + 1) * (steps_along(grid.cells_z) + 1.0));
  std::vector<LinePlace> lines;
  const auto add_lines = [&](LineAxis axis, char letter, int cells_along, int cells_across) {
    const Run run{-0.5 * cells_along * grid.cell_side_m - *overhang_m, step_m,
                  static_cast<int>(steps_along(cells_along))};
    for (int i = 0; i <= cells_across; ++i) {
      lines.push_back({fmt::format("{}{}", letter, i), axis,
                       (i - 0.5 * cells_across) * grid.cell_side_m, false, run});
    }
  };
  add_lines(LineAxis::kX, 'x', grid.cells_x, grid.cells_z);
  add_lines(LineAxis::kZ, 'z', grid.cells_z, grid.cells_x);
  return lines;
}

double stations_of(const std::vector<LinePlace>& lines) {
  double stations = 0.0;
  for (const LinePlace& line : lines) stations += line.run.steps + 1.0;
  return stations;
}

LinePlace validation_line(const CaptureConfig& config, std::size_t index, double stations_before) {
  const ValidationLine& line = config.validation[index];
  const std::string key = fmt::format("validation[{}].spacing_mm", index);
  const double length_m = line.to_m - line.from_m;
  const std::optional<double> steps = whole_steps(length_m, line.spacing_mm);
  if (!steps) {
    refuse_setting(
        config, key,
        fmt::format("is {}; whole steps of it do not fill the {:.6g} m from from_m to "
                    "to_m{}",
                    line.spacing_mm, length_m, fitting_spacings(length_m, line.spacing_mm)));
  }
  require_few_stations(config, key, line.spacing_mm, stations_before + *steps + 1.0);
  return {fmt::format("v{}", index),
          line.axis,
          line.across_m,
          true,
          {line.from_m, length_m / *steps, static_cast<int>(*steps)}};
}

bool overlap(const LinePlace& a, const LinePlace& b) {
  return a.axis == b.axis && std::abs(a.across_m - b.across_m) < kSamePlace_m &&
         a.run.first_m < b.run.last_m() + kSamePlace_m &&
         b.run.first_m < a.run.last_m() + kSamePlace_m;
}

void add_validation_lines(const CaptureConfig& config, std::vector<LinePlace>* lines) {
  for (std::size_t i = 0; i < config.validation.size(); ++i) {
    const LinePlace line = validation_line(config, i, stations_of(*lines));
    const auto other = std::find_if(lines->begin(), lines->end(), [&](const LinePlace& planned) {
      return overlap(planned, line);
    });
    if (other != lines->end()) {
      refuse_setting(config, fmt::format("validation[{}].across_m", i),
                     fmt::format("is {}, where line {} already runs", line.across_m, other->id));
    }
    lines->push_back(line);
  }
}

// The number of placements of the rail that a line is captured in; 1 if even the slider's limits
// leave no room for two stations, which require_within_limits reports.
int placements_needed(const CaptureConfig& config, const LinePlace& place) {
  const SliderConfig& slider = config.slider;
  const double step_mm = place.run.step_m * kMillimetresPerMetre;
  const double room_mm = slider.high_limit_mm - slider.first_station_mm;
  const int held = static_cast<int>(std::floor(room_mm / step_mm + kWholeStep)) + 1;
  if (slider.placements_per_line == 1 || held < 2) return 1;
  const int stations = place.run.steps + 1;
  const int needed = (stations + held - 1) / held;
  if (needed > slider.placements_per_line) {
    refuse_setting(config, "slider.placements_per_line",
                   fmt::format("is {}, but line {} of {:.6g} m needs {} placements of the rail",
                               slider.placements_per_line, place.id,
                               place.run.last_m() - place.run.first_m, needed));
  }
  if (needed > 1 && config.run.mode == CaptureMode::kVideo) {
    refuse_setting(config, "run.mode",
                   fmt::format("is video, but line {} of {:.6g} m needs {} placements of the rail; "
                               "only a line of one placement can be recorded",
                               place.id, place.run.last_m() - place.run.first_m, needed));
  }
  return needed;
}

// The placements have the same number of stations, or the first ones one more.
CaptureLine line_with_stations(const LinePlace& place, double first_station_mm, int placements) {
  CaptureLine line{place.id, place.axis, place.across_m, place.validation, {}};
  const std::size_t digits = std::max<std::size_t>(3, fmt::formatted_size("{}", place.run.steps));
  const int stations = place.run.steps + 1;
  const int each = stations / placements, longer = stations % placements;
  int left = 0;   // stations of this placement still to be added
  int first = 0;  // station of this placement
  int placement = 0;
  for (int i = 0; i < stations; ++i, --left) {
    if (left == 0) {
      first = i;
      left = each + (placement++ < longer ? 1 : 0);
    }
    const double along_m = place.run.at(i);
    line.stations.push_back(
        {fmt::format("{}_{:0{}}", place.id, i, digits),
         place.axis == LineAxis::kX ? PlanPoint{along_m, place.across_m}
                                    : PlanPoint{place.across_m, along_m},
         first_station_mm + (i - first) * place.run.step_m * kMillimetresPerMetre});
  }
  return line;
}

void require_within_limits(const CaptureConfig& config, const CaptureLine& line) {
  const SliderConfig& slider = config.slider;
  const CaptureStation& first = line.stations.front();
  const CaptureStation& last =
      *std::ranges::max_element(line.stations, {}, &CaptureStation::rail_mm);
  if (first.rail_mm < slider.low_limit_mm) {
    refuse_setting(config, "slider.low_limit_mm",
                   fmt::format("is {}, which excludes station {} at {:.3f} mm on the rail",
                               slider.low_limit_mm, first.name, first.rail_mm));
  }
  if (last.rail_mm > slider.high_limit_mm) {
    refuse_setting(config, "slider.high_limit_mm",
                   fmt::format("is {}, which excludes station {} at {:.3f} mm on the rail; shorten "
                               "the line, use a longer rail, or let the line have several "
                               "placements of the rail with slider.placements_per_line",
                               slider.high_limit_mm, last.name, last.rail_mm));
  }
}

// Rounds a length in units of 1 / `per_metre` metres to 1 nm; + 0.0 turns -0 into 0.
double rounded(double length, double per_metre) {
  const double nanometres_per_unit = 1e9 / per_metre;
  return std::round(length * nanometres_per_unit) / nanometres_per_unit + 0.0;
}
double rounded_m(double length_m) { return rounded(length_m, 1.0); }
double rounded_mm(double length_mm) { return rounded(length_mm, kMillimetresPerMetre); }

nlohmann::json json_of(const CaptureLine& line) {
  nlohmann::json stations = nlohmann::json::object();
  for (const CaptureStation& station : line.stations) {
    stations[station.name] = {{"x_m", rounded_m(station.position_m.x_m)},
                              {"z_m", rounded_m(station.position_m.z_m)},
                              {"rail_mm", rounded_mm(station.rail_mm)}};
  }
  return {{"axis", name_of(line.axis)},
          {"across_m", rounded_m(line.across_m)},
          {"validation", line.validation},
          {"stations", stations}};
}

}  // namespace

std::size_t CapturePlan::stations() const {
  return std::accumulate(
      lines.begin(), lines.end(), std::size_t{0},
      [](std::size_t sum, const CaptureLine& line) { return sum + line.stations.size(); });
}

std::vector<CaptureLine> placements_of(const CaptureLine& line) {
  std::vector<CaptureLine> placements;
  double before_mm = std::numeric_limits<double>::infinity();
  for (const CaptureStation& station : line.stations) {
    if (station.rail_mm <= before_mm) {
      const int number = static_cast<int>(placements.size()) + 1;
      placements.push_back({line.id, line.axis, line.across_m, line.validation, {}, number});
    }
    placements.back().stations.push_back(station);
    before_mm = station.rail_mm;
  }
  return placements;
}

std::string placement_id(const CaptureLine& placement) {
  if (placement.placement == 1) return placement.id;
  return fmt::format("{}-{}", placement.id, placement.placement);
}

std::vector<CaptureLine> placements_of(const CapturePlan& plan) {
  std::vector<CaptureLine> all;
  for (const CaptureLine& line : plan.lines) {
    for (CaptureLine& placement : placements_of(line)) all.push_back(std::move(placement));
  }
  return all;
}

// A viewpoint in a cell has the distance b to one side and a to an adjacent side. It sees their
// corner at the angle c = atan2(a, b) from the normal of the first side. The hybrid connection
// switches between the lines of the two sides at the cut clamp(c, 90 - k, k). A ray at the angle g
// from that normal meets the second line at a / tan(g) along it, which is a / tan(g) - b beyond the
// corner. With the cut at k, the blend reads the second line down to g = k - blend / 2, and the
// overhang is largest at a = N, b = 0: a viewpoint on the first side, at its far end. (A cut at 90
// - k is the same with the lines exchanged.) The other half of the blend, and the blend of a cut
// that is not clamped, is narrowed where lines end.
double overhang_needed_m(const CaptureGrid& grid) {
  return grid.cell_side_m / std::tan(radians_from_degrees(grid.k_deg - 0.5 * grid.blend_deg));
}

// If the overhang o is too short for k, views connect at atan2(a, b + o), which is largest at a =
// N, b = 0.
double angle_reached_deg(const CaptureGrid& grid, double overhang_m) {
  return std::max(grid.k_deg, degrees_from_radians(std::atan2(grid.cell_side_m, overhang_m)));
}

CapturePlan plan_capture(const CaptureConfig& config) {
  CapturePlan plan;
  std::vector<LinePlace> places = grid_lines(config, &plan.overhang_m);
  add_validation_lines(config, &places);
  for (const LinePlace& place : places) {
    plan.lines.push_back(line_with_stations(place, config.slider.first_station_mm,
                                            placements_needed(config, place)));
    require_within_limits(config, plan.lines.back());
  }
  return plan;
}

std::string plan_json(const CapturePlan& plan, const CameraConfig& camera) {
  nlohmann::json lines = nlohmann::json::object();
  for (const CaptureLine& line : plan.lines) lines[line.id] = json_of(line);
  nlohmann::json json{{"frames", name_of(camera.frames)},
                      {"bracket_ev", camera.exposure.bracket_ev},
                      {"lines", lines}};
  if (plan.part_of) {
    json["part_of"] = {{"lines", plan.part_of->lines}, {"sha256", plan.part_of->sha256}};
  }
  return json.dump();
}

}  // namespace raywalk::capture
