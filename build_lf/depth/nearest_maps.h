// Finds the stations with maps that are nearest to a station, without visiting all of them.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {

// Where a map is.
struct MapPlace {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
};

class NearestMaps {
 public:
  explicit NearestMaps(std::vector<MapPlace> maps);

  // The `own` nearest maps of the station's line and the `others` nearest of all other lines, fewer
  // where there are not so many; without that of the station itself. As indices of the list, by
  // increasing distance from `position_m`, equal distances by index.
  std::vector<int> around(StationIndex station, const Eigen::Vector3d& position_m, std::size_t own,
                          std::size_t others) const;

 private:
  std::vector<MapPlace> maps_;
  // Places along a direction of the plan that is oblique to all lines, in order, and their maps:
  // only those near a place there can be near it.
  std::vector<std::pair<double, int>> order_;
};

}  // namespace raywalk::build_lf
