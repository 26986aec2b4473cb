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
        fmt::format("line {}: no line crosses it, so nothing shows whether it agrees with the "
                    "others; its poses stay {}; capture a line across it",
                    line.id, stay));
    return;
  }
  result->warnings.push_back(fmt::format(
      "line {}: nothing connects it to the other lines, too few features match at its crossings; "
      "its poses stay {}; check that it was captured in the same room and lies where the plan has "
      "it",
      line.id, stay));
}

// A rail laid where another line belongs gives a grid that agrees with itself, and is not the
// plan's.
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
      "line {}: found {:.0f} mm from where the plan has it, nearer to the place of line {}; if the "
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
        "line {}: the solved poses of {} contradict the rail and were replaced by what it predicts",
        line.id, names_of(set, line.rejected_frames));
    const bool many = rejected > kManyRejected * (rejected + line.solved_stations);
    (many ? result->warnings : result->notes)
        .push_back(many ? what + "; that is many of its stations: solve the poses again" : what);
  }
  const int predicted = line.stations - line.solved_stations;
  if (predicted > 0 && line.solved_stations > 0) {
    result->notes.push_back(
        fmt::format("line {}: {} of {} stations have no pose of their own and stand where the rail "
                    "has them, within {:.2g} mm and {:.2g} degrees",
                    line.id, predicted, line.stations, line.jitter_mm, line.jitter_deg));
  }
  if (line.jitter_mm > 1e3 * kLargeScatter_spacings * scale.spacing_m ||
      line.jitter_along_mm > 1e3 * kLargeScatter_spacings * scale.spacing_m ||
      line.jitter_deg > kLargeScatter_deg) {
    result->warnings.push_back(fmt::format(
        "line {}: its stations scatter by {:.2g} mm along the rail, {:.2g} mm across it and {:.2g} "
        "degrees, more than a rail does; the solved poses or the slider's positions are wrong",
        line.id, line.jitter_along_mm, line.jitter_mm, line.jitter_deg));
  }
}

// The crossings put lines right that were solved a little wrong; much wrong ones are wrong in ways
// that a few crossings cannot tell.
void warn_of_solved_lines(const GridScale& scale, GridResult* result) {
  constexpr double kLargest_spacings = 0.08;
  constexpr double kLargest_deg = 0.18;  // two pixels at W = 4096
  if (result->solved_line_error_mm <= 1e3 * kLargest_spacings * scale.spacing_m &&
      result->solved_line_error_deg <= kLargest_deg) {
    return;
  }
  result->warnings.push_back(fmt::format(
      "the solved poses of whole lines are off by {:.2g} mm and {:.2g} degrees against what is "
      "seen "
      "at the crossings; solve the poses again with more keyframes, or use --method rotation",
      result->solved_line_error_mm, result->solved_line_error_deg));
}

}  // namespace

void add_warnings(const CaptureSet& set, const GridScale& scale, GridResult* result) {
  if (set.lines.size() == 1) {
    result->notes.push_back(
        "one line only: there is nothing for it to agree with, so calibration straightens it and "
        "no "
        "more, and no crossing checks the result");
  }
  for (const LineFit& line : result->lines) {
    if (set.lines.size() > 1) warn_of_connection(line, result);
    warn_of_place(set, line, result);
    warn_of_stations(set, line, scale, result);
  }
  warn_of_solved_lines(scale, result);
  if (result->method == GridMethod::kRotation) {
    result->notes.push_back(
        "without solved poses, lines are moved and turned as a whole by what their crossings show; "
        "stations away from the crossings are known only as well as a rail runs straight");
  }
  for (const CrossingFigures& crossing : result->crossings) {
    result->warnings.insert(result->warnings.end(), crossing.warnings.begin(),
                            crossing.warnings.end());
  }
  result->trustworthy = result->warnings.empty();
}

}  // namespace raywalk::calibrate
