#include "calibrate/grid/estimate_grid.h"

#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/grid_estimation.h"
#include "calibrate/grid/grid_page.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::calibrate {

GridResult estimate_grid(const CaptureSet& panoramas, const FramePoses& solved,
                         const GridOptions& options) {
  // A frame without an initial pose starts at its nominal pose.
  FramePoses start = nominal_poses(panoramas);
  for (size_t i = 0; i < std::min(start.size(), options.start.size()); ++i) {
    if (options.start[i]) start[i] = options.start[i];
  }
  const std::vector<CrossingMatches> crossings =
      find_crossing_matches(panoramas, start, options.mask, options.lenses);
  GridResult result = estimate_from_matches(panoramas, options.method, solved, start, crossings);
  make_directories(options.out);
  write_grid_result(options.out / "grid.json", panoramas, result);
  write_file_atomically(options.out / "grid.html", grid_page(panoramas, result));
  return result;
}

}  // namespace raywalk::calibrate
