#include "calibrate/rectify/frame_tables.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/station_spacing.h"

namespace raywalk::calibrate {
namespace {

std::vector<StationPose> stations_of(const std::vector<ListedFrame>& frames) {
  std::vector<StationPose> stations;
  stations.reserve(frames.size());
  for (const ListedFrame& frame : frames) stations.push_back({frame.file, frame.position_m, {}});
  return stations;
}

// False if another number of lines is found: stations on both sides of their line may look like two
// parallel lines.
bool finds_lines(const std::vector<StationPose>& stations, GridTolerance tolerance, int lines) {
  try {
    return static_cast<int>(find_grid(stations, tolerance).lines.size()) == lines;
  } catch (const Error&) {
    return false;
  }
}

// The tolerances to try, millimetres, in ascending order.
std::vector<double> tolerances_mm(const std::vector<StationPose>& stations,
                                  const GridTolerance& given) {
  const double spacing_mm = 1000.0 * typical_spacing(stations);
  std::vector<double> tolerances;
  if (spacing_mm > 0.0) {
    for (const double share : {0.15, 0.2, 0.3, 0.4, 0.5}) {
      // Rounded to two significant digits for the command line.
      const double step_mm = std::pow(10.0, std::floor(std::log10(share * spacing_mm)) - 1.0);
      tolerances.push_back(std::round(share * spacing_mm / step_mm) * step_mm);
    }
  }
  if (given.off_line_m) tolerances.push_back(1000.0 * *given.off_line_m);
  std::sort(tolerances.begin(), tolerances.end());
  return tolerances;
}

}  // namespace

std::optional<double> line_tolerance_needed_mm(const std::vector<ListedFrame>& frames, int lines,
                                               const GridTolerance& given) {
  if (frames.empty()) return std::nullopt;
  const std::vector<StationPose> stations = stations_of(frames);
  GridTolerance tolerance{.off_line_m = std::nullopt, .same_station_m = given.same_station_m};
  if (finds_lines(stations, tolerance, lines)) return 0.0;
  for (const double tolerance_mm : tolerances_mm(stations, given)) {
    tolerance.off_line_m = tolerance_mm / 1000.0;
    if (finds_lines(stations, tolerance, lines)) return tolerance_mm;
  }
  return std::nullopt;
}

}  // namespace raywalk::calibrate
