// Which points of a column a line's stations see, by their own distance maps.
//
// RingVisibility knows only what the viewpoint sees. A chair just below a line hides from its
// stations what the viewpoint sees past the chair, although the chair may be hidden from the
// viewpoint, be seen by it too obliquely, or be beside the plane of the column.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/eye_circle.h"
#include "core/room/room.h"
#include "core/view/column_kernels.h"
#include "core/view/distance_view.h"
#include "core/view/row_table.h"

namespace raywalk {

// Up to two neighbouring stations of a line.
struct StationPair {
  int line = -1;
  int first = 0;                         // `first` and `first` + 1
  std::array<bool, 2> read{true, true};  // which of them are read
};

class StationVisibility {
 public:
  // For the distances of an eye. Room and distances must outlive the object.
  StationVisibility(const Room& room, const DistanceView& distances, const EyeCircle& eye);

  // Sets visible[row] = 0 where one of the stations does not see what the viewpoint sees in that
  // row of column `theta`, of the size of the distances. A station does not see a point if one of
  // the four pixels of its map around it holds a surface that is confident and clearly nearer. A
  // station without a map of its own sees what one of the maps before and after it on the line
  // sees; without any map on the line nothing changes.
  void remove_hidden(const StationPair& stations, int theta, std::span<std::uint8_t> visible);

 private:
  struct MapRows {
    int map = -1;
    std::vector<std::uint8_t> hidden;
  };
  struct Lookup;
  const std::vector<std::uint8_t>& hidden_in(int line, int map, int theta,
                                             std::span<const std::uint8_t> visible);
  void find_suspects(const Lookup& lookup);
  void check_rows(const Lookup& lookup, int first, int end, std::span<const std::uint8_t> visible,
                  std::vector<std::uint8_t>* hidden);
  bool between_nearer(int theta, int row) const;
  bool viewpoint_agrees(const Lookup& lookup, const Eigen::Vector3f& occluder_m) const;

  const Room& room_;
  const DistanceView& distances_;
  EyeCircle eye_;
  LatitudeTable latitudes_;
  int step_;  // every step-th row is looked up first
  std::vector<float> coarse_sin_phi_, coarse_cos_phi_, coarse_omega_;  // of these rows
  std::vector<std::uint8_t> suspect_;  // rows next to one where the map shows something nearer
  std::vector<float> omega_there_;
  std::vector<std::int32_t> left_, right_;
  std::array<MapRows, 4> known_;  // of the maps looked up in the current call
  std::size_t known_count_ = 0;
};

}  // namespace raywalk
