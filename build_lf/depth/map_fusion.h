// Fusion of neighbouring distance maps by voting.
//
// A line has no parallax along its rail, and a station does not see occluded surfaces; other maps
// do. Every map proposes a surface for every pixel, and all maps vote on each proposal.
#pragma once

#include <span>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {

struct FusionOptions {
  // Maps agree if their inverse distances differ by at most this, 1/m, plus the change over half a
  // pixel of a slanted surface.
  double tolerance_per_m = 0.0;
  // For frames with masks: a masked view of a surface is no evidence against it, so shares of votes
  // are relative to the number of maps with a value there, but at least to this number. 0: relative
  // to all maps.
  int min_voters = 0;
  // The last `fallback_maps` maps are used only where maps[which] has confidence 0.
  int fallback_maps = 0;
};

// Fuses `maps[which]` with all `maps` (all of one size). `colours` has the ranges_of() the colours
// of each map's station, of the maps' size; empty: colours are not compared.
//
// A proposal gains a vote, weighted by agreement, from each map that sees a surface there, and
// loses one for each map that sees through it to a farther surface; a map in which it is occluded
// abstains (visibility as in Merrell et al. 2007). A map that sees a surface there, but whose
// station shows it in another colour, votes against it instead: it sees something else, as beside
// an outline, or where surfaces without texture left the distance open. The proposal with the most
// votes wins. The result is the mean over the winner's voters, weighted by confidence. Its
// confidence is the winner's share of the votes. A pixel with confidence 0 has no value.
InverseDistanceMap fuse_maps(std::span<const InverseDistanceMap> maps, int which,
                             const FusionOptions& options, std::span<const cv::Mat> colours = {});

}  // namespace raywalk::build_lf
