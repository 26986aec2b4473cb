// Pass 5, first part: which station shows a point that the lines in use do not see.
//
// Some 50 operations per station searched, once per pixel of the distances that needs one.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/room/room.h"
#include "core/view/distance_view.h"
#include "core/view/map_choice.h"

namespace raywalk {

// What a view shows in a pixel of its distances.
struct ViewPoint {
  Eigen::Vector3d eye_m{0, 0, 0};  // of the pixel's column
  Eigen::Vector3f direction{0, 0, 1};
  float inverse = 0.0f;  // distance from the eye, 1/m
  float trust = 1.0f;    // in the distance, 0 to 1
};
ViewPoint point_in(const DistanceView& distances, int theta, int row);

class FillStations {
 public:
  static constexpr int kNone = -1;

  FillStations() = default;
  // `maps`: of the stations that are searched, nearest first. The room must outlive the object.
  FillStations(const Room& room, std::vector<MapStation> maps)
      : room_(&room), maps_(std::move(maps)) {}

  std::span<const MapStation> maps() const { return maps_; }
  const MapStation& station(int index) const { return maps_[static_cast<std::size_t>(index)]; }

  // The station that shows a point of a view's distances, as an index, or kNone. Next to a
  // silhouette a captured pixel is part foreground: a station that sees the point away from nearer
  // surfaces is preferred to a nearer one that sees it at a silhouette. What moved is shown only
  // where no other station sees the place.
  int find(const DistanceView& distances, const ViewPoint& point) const;

  // Whether one of the pixels of a station around a point is left out.
  bool is_left_out(const MapStation& map, const ViewPoint& point) const;

 private:
  // Without a distance to rely on it is not known which stations see the point, and farther
  // stations would show something else.
  int find_unmasked(const DistanceView& distances, const ViewPoint& point) const;
  // Whether the pixels of a station that a pixel of the distances covers are unmasked.
  bool is_unmasked(const MapStation& map, const DistanceView& distances,
                   const ViewPoint& point) const;

  const Room* room_ = nullptr;
  std::vector<MapStation> maps_;
};

}  // namespace raywalk
