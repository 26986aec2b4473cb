// Finds the stations with maps that are nearest to a station, without visiting all of them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/geometry/station_tree.h"

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
  // The same of the maps at most `reach_m` away in the plan.
  std::vector<int> within(double reach_m, StationIndex station, const Eigen::Vector3d& position_m,
                          std::size_t own, std::size_t others) const;

  std::vector<MapPlace> maps_;
  StationTree tree_;
  double extent_m_ = 0.0;   // no two maps are farther apart in the plan
  double typical_m_ = 0.0;  // of the order of the distance between neighbours
};

}  // namespace raywalk::build_lf
