// What a depth run is going to do: which stations get maps, how large, and how far to look.
#pragma once

#include <filesystem>
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
  int every = 0;  // a map at every n-th station; 0: as dense as the cell's size requires
  // Of the maps, a multiple of 4, 32 or more; 0: the panoramas', rounded down, but at most 1024.
  int width = 0;
  // 8-bit grey, as large as the maps, in world axes; 0 = not to be used.
  std::optional<std::filesystem::path> valid_mask{};
  bool compare_truth = false;  // with the distances that were packed with the room
  // Estimate as if one of every so many stations (held_out_stations()) had never been captured, and
  // keep the maps in held_out_directory() for raywalk-render trade --held-out; 0: use all.
  int hold_out = 0;
};

struct DepthPlan {
  PanoramaSize size;
  // Half the side of the smallest cell: as far as a viewpoint gets from the nearest line, and the
  // longest baseline aimed at. Where no cell is closed, a quarter of the longest line.
  double reach_m = 0.0;
  std::vector<SweepReference> maps;  // in the order of lines and stations
  // Stations that may be compared, thinned where they lie closer than a tenth of the reach.
  std::vector<SweepCandidate> candidates;

  // By how many pixels a surface moves over the reach, per 1/m of its inverse distance; so also the
  // distance in metres from which on it moves by less than one.
  double pixels_per_omega_m() const { return reach_m * size.width / kTwoPi; }
};

// Throws UsageError: an `every` or `width` out of range; Error: panoramas less than 32 wide.
DepthPlan plan_depth(const Room& room, const DepthOptions& options);

// Leaves stations out of a plan: they get no maps and are compared with none. Throws Error where no
// map is left, or two stations on no line.
void leave_out(std::span<const StationIndex> stations, DepthPlan* plan);

// The maps whose votes are heard for maps[which]: itself first, then the nearest four of its own
// line and the nearest eight of others.
std::vector<int> voters_of(const DepthPlan& plan, int which);

// Further maps that are asked where masks hide what is below from all of `voters`: at most eight,
// nearest first, each at least a quarter of its own distance from those and from one another, so
// that they reach over the room.
std::vector<int> fallback_voters_of(const DepthPlan& plan, std::span<const int> voters);

// The candidates within three reaches of a reference: what lies farther off is never the best view.
std::vector<SweepCandidate> candidates_near(const DepthPlan& plan, const SweepReference& reference);

}  // namespace raywalk::build_lf
