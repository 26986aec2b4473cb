#include "calibrate/grid/grid_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

// "x0_003, x0_007 and 4 more".
std::string names_of(const CaptureSet& set, const std::vector<int>& frames) {
  constexpr size_t kShown = 5;
  std::string names;
  for (size_t i = 0; i < std::min(kShown, frames.size()); ++i) {
    names += (i == 0 ? "" : ", ") + set.frames[static_cast<size_t>(frames[i])].name;
  }
  if (frames.size() > kShown) names += fmt::format(" and {} more", frames.size() - kShown);
  return names;
}

bool is_crossed(const GridResult& result, int line) {
  return std::any_of(result.crossings.begin(), result.crossings.end(),
                     [&](const CrossingFigures& crossing) {
                       return crossing.along_x == line || crossing.along_z == line;
                     });
}

void warn_of_connection(const LineFit& line, GridResult* result) {
  if (line.connected) return;
  const char* stay = line.solved_stations > 0 ? "as they were solved" : "as planned";
  if (!is_crossed(*result, line.line)) {
    result->warnings.push_back(
        fmt::format("line {}: no line crosses it, so its agreement with the others cannot be "
                    "checked; its poses stay {}; capture a line across it",
                    line.id, stay));
    return;
  }
  result->warnings.push_back(fmt::format(
      "line {}: not connected to the other lines, too few features match at its crossings; its "
      "poses stay {}; check that it was captured in the same room and lies where it was planned",
      line.id, stay));
}

// A rail laid at the place of another line gives a consistent grid that differs from the plan.
void warn_of_place(const CaptureSet& set, const LineFit& line, GridResult* result) {
  const CaptureLine& own = set.lines[static_cast<size_t>(line.line)];
  const double found_m = own.across_m + 1e-3 * line.across_mm.value;
  const CaptureLine* nearest = &own;
  for (const CaptureLine& other : set.lines) {
    if (other.axis == own.axis &&
        std::abs(found_m - other.across_m) < std::abs(found_m - nearest->across_m)) {
      nearest = &other;
    }
  }
  if (nearest == &own) return;
  result->warnings.push_back(fmt::format(
      "line {}: found {:.0f} mm from where it was planned, nearer to the place of line {}; if the "
      "rail was laid there, exchange the lines in the plan or in poses.csv, else capture the line "
      "again",
      line.id, std::abs(line.across_mm.value), nearest->id));
}

void warn_of_stations(const CaptureSet& set, const LineFit& line, const GridScale& scale,
                      GridResult* result) {
  constexpr double kManyRejected = 0.2;
  constexpr double kLargeScatter_spacings = 0.25;
  constexpr double kLargeScatter_deg = 1.5;
  if (!line.rejected_frames.empty()) {
    const auto rejected = static_cast<double>(line.rejected_frames.size());
    const std::string what = fmt::format(
        "line {}: the solved poses of {} contradict the rail and were replaced by its prediction",
        line.id, names_of(set, line.rejected_frames));
    const bool many = rejected > kManyRejected * (rejected + line.solved_stations);
    (many ? result->warnings : result->notes)
        .push_back(many ? what + "; that is many of its stations: solve the poses again" : what);
  }
  const int predicted = line.stations - line.solved_stations;
  if (predicted > 0 && line.solved_stations > 0) {
    result->notes.push_back(
        fmt::format("line {}: {} of {} stations have no solved pose and are predicted from the "
                    "rail, within {:.2g} mm and {:.2g} degrees",
                    line.id, predicted, line.stations, line.jitter_mm, line.jitter_deg));
  }
  if (line.jitter_mm > 1e3 * kLargeScatter_spacings * scale.spacing_m ||
      line.jitter_along_mm > 1e3 * kLargeScatter_spacings * scale.spacing_m ||
      line.jitter_deg > kLargeScatter_deg) {
    result->warnings.push_back(fmt::format(
        "line {}: its stations scatter by {:.2g} mm along the rail, {:.2g} mm across it and {:.2g} "
        "degrees, too much for a rail; the solved poses or the slider's positions are wrong",
        line.id, line.jitter_along_mm, line.jitter_mm, line.jitter_deg));
  }
}

// The crossings correct small common errors of solved lines. Large errors have components that a
// few crossings do not determine.
void warn_of_solved_lines(const GridScale& scale, GridResult* result) {
  constexpr double kLargest_spacings = 0.08;
  constexpr double kLargest_deg = 0.18;  // two pixels at W = 4096
  if (result->solved_line_error_mm <= 1e3 * kLargest_spacings * scale.spacing_m &&
      result->solved_line_error_deg <= kLargest_deg) {
    return;
  }
  result->warnings.push_back(fmt::format(
      "the solved poses of whole lines are off by {:.2g} mm and {:.2g} degrees by the matches at "
      "the crossings; solve the poses again with more keyframes, or use --method rotation",
      result->solved_line_error_mm, result->solved_line_error_deg));
}

}  // namespace

void add_warnings(const CaptureSet& set, const GridScale& scale, GridResult* result) {
  if (set.lines.size() == 1) {
    result->notes.push_back("one line only: it is straightened, but no crossing checks the result");
  }
  for (const LineFit& line : result->lines) {
    if (set.lines.size() > 1) warn_of_connection(line, result);
    warn_of_place(set, line, result);
    warn_of_stations(set, line, scale, result);
  }
  warn_of_solved_lines(scale, result);
  if (result->method == GridMethod::kRotation) {
    result->notes.push_back(
        "without solved poses, lines are moved and rotated as a whole by their crossings; stations "
        "away from the crossings are known only as well as the rail is straight");
  }
  for (const CrossingFigures& crossing : result->crossings) {
    result->warnings.insert(result->warnings.end(), crossing.warnings.begin(),
                            crossing.warnings.end());
  }
  result->trustworthy = result->warnings.empty();
}

}  // namespace raywalk::calibrate
