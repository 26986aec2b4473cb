#include "calibrate/grid/estimate_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibrate/grid/crossing_matches.h"
#include "calibrate/grid/grid_estimation.h"
#include "calibrate/grid/held_out_poses.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"

namespace raywalk::calibrate {
namespace {

// Names the held-out frames without a pose. `held_out` are their poses, in order.
void add_note(const CaptureSet& set, const FramePoses& held_out, GridMethod method,
              GridResult* result) {
  std::string names;
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    if (held_out[i]) continue;
    names += (names.empty() ? "" : ", ") + set.frames[set.stations() + i].name;
  }
  if (names.empty()) return;
  result->notes.push_back(fmt::format(
      "held-out frames without a pose, left out of gt.csv: {}{}", names,
      method == GridMethod::kRotation ? " (--method rotation solves none of them)" : ""));
}

}  // namespace

GridResult estimate_grid(const CaptureSet& panoramas, const FramePoses& solved,
                         const GridOptions& options) {
  const CaptureSet stations = stations_only(panoramas);
  // A station without an initial pose starts at its nominal pose.
  FramePoses start = nominal_poses(stations);
  for (size_t i = 0; i < std::min(start.size(), options.start.size()); ++i) {
    if (options.start[i]) start[i] = options.start[i];
  }
  const std::vector<CrossingMatches> crossings =
      find_crossing_matches(stations, start, options.mask, options.lenses);
  const auto count = std::min(solved.size(), stations.frames.size());
  GridResult result = estimate_from_matches(
      stations, options.method,
      {solved.begin(), solved.begin() + static_cast<std::ptrdiff_t>(count)}, start, crossings);
  // A pose that no picture was asked for would be no truth.
  const FramePoses held_out = options.method == GridMethod::kPoses
                                  ? held_out_poses(panoramas, solved, result)
                                  : FramePoses(panoramas.frames.size() - stations.frames.size());
  add_note(panoramas, held_out, options.method, &result);
  result.poses.insert(result.poses.end(), held_out.begin(), held_out.end());
  make_directories(options.out);
  write_file_atomically(options.out / "grid.json", json_text(grid_document(panoramas, result)));
  return result;
}

}  // namespace raywalk::calibrate
