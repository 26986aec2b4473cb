// The plan of a depth run: which stations get maps, the size of the maps, and the search range.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/plane_sweep.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

enum class DepthMethod { kSweep, kFlow };

// Throws UsageError naming both methods.
DepthMethod depth_method_from_name(const std::string& name);
std::string name_of(DepthMethod method);

struct DepthOptions {
  std::filesystem::path room{};
  DepthMethod method = DepthMethod::kSweep;
  int every = 0;  // a map at every n-th station; 0: chosen from the cell size
  // Width of the maps, a multiple of 4, at least 32; 0: that of the panoramas, at most 1024.
  int width = 0;
  // 8-bit grey image of the maps' size, in world axes; 0 = invalid.
  std::optional<std::filesystem::path> valid_mask{};
  bool compare_truth = false;  // compare with the distances packed with the room
  // Leave out one of every `hold_out` stations (held_out_stations()) and store the maps in
  // held_out_directory(), for raywalk-render trade --held-out; 0 uses all stations.
  int hold_out = 0;
  // Marks what single stations show and the others contradict, so that views leave it out.
  bool leave_out_moving = true;
  // Whether the room gets the gains that were found (build_lf/exposure); not with hold_out.
  bool gains = true;
};

struct DepthPlan {
  PanoramaSize size;
  // Half the side of the smallest cell, which is the largest distance of a viewpoint from the
  // nearest line; also the longest baseline used. Without cells, a quarter of the longest line, or
  // less if surfaces are near (plan_depth).
  double reach_m = 0.0;
  std::vector<SweepReference> maps;  // in the order of lines and stations
  // Stations to compare with, thinned where they are closer than a tenth of the reach.
  std::vector<SweepCandidate> candidates;

  // Parallax over the reach, in pixels per 1/m of inverse distance. Equals the distance in metres
  // at which the parallax is one pixel.
  double pixels_per_inverse_m() const { return reach_m * size.width / kTwoPi; }
  StationIndex station_of(int map) const { return maps[static_cast<size_t>(map)].station; }
};

// `surfaces_m`: the distance of near surfaces (NearSurfaces), infinity while it is not known.
// Without cells it limits the reach: such a surface is seen from the ends of the longest baseline
// at angles at most 30 degrees apart, unless even neighbours on the lines are farther apart. Throws
// UsageError if `every` or `width` is out of range, Error if panoramas are less than 32 wide.
DepthPlan plan_depth(const Room& room, const DepthOptions& options,
                     double surfaces_m = std::numeric_limits<double>::infinity());

// Removes stations from a plan, both as maps and as candidates. Throws Error if no map is left, or
// no line has two stations left.
void exclude_stations(std::span<const StationIndex> stations, DepthPlan* plan);

// The maps that vote in the fusion of maps[which]: itself first, then the nearest four of its own
// line and the nearest eight of other lines.
std::vector<int> voters_of(const DepthPlan& plan, int which);

// Fallback maps for pixels that masks hide from all of `voters`, such as the floor below: at most
// eight, nearest first. Each is at least a quarter of its own distance away from the voters and
// from the other fallback maps, so that they spread over the room.
std::vector<int> fallback_voters_of(const DepthPlan& plan, std::span<const int> voters);

// The candidates within three reaches of a reference; those farther away are never the best views.
std::vector<SweepCandidate> candidates_near(const DepthPlan& plan, const SweepReference& reference);

}  // namespace raywalk::build_lf
