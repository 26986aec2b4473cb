// Fusion of neighbouring maps: the distance that the maps around agree on.
//
// Each line is blind along its own rail and each station behind what stands before it; others are
// not. Every map proposes a surface for every pixel, and all maps vote on each proposal.
#pragma once

#include <span>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {

struct FusionOptions {
  // Maps agree where their inverse distances differ by at most this, 1/m, and what half a pixel
  // makes on a slanted surface.
  double tolerance_per_m = 0.0;
  // For frames with masks: that a station's view of a surface is masked says nothing against the
  // surface, so votes are counted in shares of the maps that know something there, but of this many
  // at least. 0: of all maps.
  int fewest_voters = 0;
  // So many of the last maps are asked only where maps[which] knows nothing.
  int fallback_maps = 0;
};

// The map of `maps[which]` after the vote of all `maps` (all of one size).
//
// A proposal gains a vote, less where it agrees less, from each map that sees a surface there, and
// loses one where a map sees through it to something farther; a map whose view of it is blocked by
// something nearer abstains (visibility as in Merrell et al. 2007). The most votes win; but of
// surfaces that enough maps see and hardly any sees through, the nearest, for thin things are seen
// past by all that see what is behind them. The winner is the mean of what its voters see, weighted
// by how sure they are; a 3 x 3 median removes single pixels. Confidence is the share of votes that
// the winner got. A map knows nothing where its confidence is 0.
InverseDistanceMap fuse_maps(std::span<const InverseDistanceMap> maps, int which,
                             const FusionOptions& options);

}  // namespace raywalk::build_lf
