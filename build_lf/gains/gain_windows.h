// Divides the stations of a large room into windows whose gains are solved for one by one.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "build_lf/gains/station_ratios.h"

namespace raywalk::build_lf {

// Stations by their index in the list, increasing.
struct GainWindow {
  std::vector<int> stations;
  // [place in `stations`]: whether the gains are kept. Those of the others, around the window, are
  // only solved for because those within depend on them.
  std::vector<bool> kept;
};

// Halves the room across its longer side until no window keeps more than `most` stations; each
// station is kept by one window. A window also has the stations that its own are compared with, and
// those that these are. One window if there are at most `most` stations.
std::vector<GainWindow> gain_windows(std::span<const Eigen::Vector3d> positions_m,
                                     std::span<const WholeRatio> pairs, int most);

}  // namespace raywalk::build_lf
